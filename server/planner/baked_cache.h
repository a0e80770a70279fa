// Baked models opened, the ones used last, so that a plan does not check its asset's file each time.
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/texture/choice.h"
#include "server/bake/baked_model.h"
#include "server/bake/scene_colors.h"
#include "server/bake/shells.h"
#include "server/store/mapped_file.h"
#include "server/store/store.h"

namespace lodestream::planner {

inline constexpr std::uint64_t max_cached_bytes = 4ull
                                                  << 30;  // of all opened assets; the system pages them out at will
inline constexpr std::uint64_t max_baked_bytes = 16ull << 30;  // of one stored baked model

// One asset ready to be cut, in the store's own files. Immutable.
struct LoadedAsset {
    std::vector<store::MappedFile> files;
    bake::BakedView baked;                    // in the files, as the shells are
    std::vector<bake::ShellView> shells;      // none where the asset is one object
    std::optional<bake::SceneColors> colors;  // of shells that have none of their own
    texture::Textures textures;
    Box world_bounds;  // bounds + origin
};

class BakedCache {
  public:
    explicit BakedCache(store::Store& store) : store_(store) {}

    Result<std::shared_ptr<const LoadedAsset>> load(const std::string& asset_id);
    void forget(const std::string& asset_id);

  private:
    struct Entry {
        std::string asset_id;
        std::string hash;
        std::uint64_t bytes = 0;
        std::shared_ptr<const LoadedAsset> asset;
    };
    void make_room();

    store::Store& store_;
    std::mutex mutex_;          // held while loading too: two plans never load one asset twice
    std::list<Entry> entries_;  // used last first
};

}  // namespace lodestream::planner
