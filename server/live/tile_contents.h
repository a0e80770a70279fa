// The contents of a changed scene's tiles: of objects where they are now, and of a tile above others from what those
// show. Pure but for the files that are read and written.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/scene/placement.h"
#include "server/bake/scene_source.h"
#include "server/live/transient_files.h"

namespace lodestream::live {

// A stored level.
struct Content {
    std::string hash;
    std::uint64_t bytes = 0;
    std::uint64_t triangles = 0;
    double error = 0.0;  // model units: what it is off from the objects as they were when it was made
    Box box;             // world axes
    FileKeeper keeper;   // none where a bake has stored it
    Mat4d matrix{1.0};   // from its own coordinates to those of the world as the source has it
};

struct PlacedObject {
    std::uint32_t object = 0;
    scene::Placement placement;
};

struct PlacedContent {
    Content content;
    scene::Placement placement;
};

// What a stored level shows, as it lies: in its own world coordinates. Errors: invalid_input (it is none).
Result<Content> content_of(const store::StoredFile& file, std::span<const std::byte> glb, double error);

inline constexpr std::uint64_t max_tile_bytes = 1ull << 30;

// A level among the store's files. Errors: not_found, limit_exceeded (max_tile_bytes), those of reading.
struct StoredLevel {
    store::StoredFile file;
    std::vector<std::byte> glb;
};
Result<StoredLevel> read_level(const store::Store& store, const std::string& hash);

// The visible ones of these objects as one content at their finest; of no triangles where none is. `is_exact`: whether
// its grid is as fine as that of objects that stay where they are; farther apart they would have to share a coarser
// one.
struct ObjectsContent {
    Content content;
    bool is_exact = true;
};
Result<ObjectsContent> make_objects_content(TransientFiles& files, const bake::SceneSource& source,
                                            std::span<const PlacedObject> objects);

// `count` levels of what these contents show together, the finest first, as a bake makes the tiles above others
// (bake/hlod.h); the last one again where fewer triangles cannot be had. Colours are those of the contents. A content
// that is not visible is left out. Errors: unavailable (`goes_on` returned false), those of reading and encoding.
// pre: one is visible and has triangles; count > 0
Result<std::vector<Content>> make_levels_above(TransientFiles& files, const store::Store& store,
                                               const mesh::Model& source, std::span<const PlacedContent> below,
                                               std::size_t count, bool is_root, const std::function<bool()>& goes_on);

}  // namespace lodestream::live
