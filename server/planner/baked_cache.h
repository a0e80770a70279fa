// Baked models in memory, the ones used last, so that a plan does not read its asset from disk each time.
#pragma once

#include <cstdint>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "common/base/result.h"
#include "common/metric/surface_distance.h"
#include "common/texture/choice.h"
#include "server/bake/bake.h"
#include "server/store/store.h"

namespace lodestream::planner {

inline constexpr std::uint64_t max_cached_bytes = 4ull << 30;  // of all loaded assets, estimated from their stored size
inline constexpr std::uint64_t memory_per_stored_byte = 4;     // arrays, distance index, samples
inline constexpr std::uint64_t max_baked_bytes = 16ull << 30;  // of one stored baked model
inline constexpr std::size_t max_remembered_errors = 4'096;    // of one asset

// One asset ready to be cut. Immutable but for the errors remembered.
struct LoadedAsset {
    LoadedAsset(bake::BakedModel model, texture::Ladder ladder);

    bake::BakedModel baked;
    texture::Textures textures;
    metric::SurfaceIndex index;
    Box bounds;        // model space
    Box world_bounds;  // bounds + origin

    // The level's measured error; measured once for each triangle count.
    metric::SurfaceError error_of(const mesh::Mesh& level, double& measure_ms);

  private:
    std::mutex mutex_;
    std::map<std::uint64_t, metric::SurfaceError> errors_;
};

class BakedCache {
  public:
    explicit BakedCache(store::Store& store) : store_(store) {}

    Result<std::shared_ptr<LoadedAsset>> load(const std::string& asset_id);
    void forget(const std::string& asset_id);

  private:
    struct Entry {
        std::string asset_id;
        std::string hash;
        std::uint64_t bytes = 0;
        std::shared_ptr<LoadedAsset> asset;
    };
    void make_room();

    store::Store& store_;
    std::mutex mutex_;          // held while loading too: two plans never load one asset twice
    std::list<Entry> entries_;  // used last first
};

}  // namespace lodestream::planner
