#include "server/bake/first_levels.h"

#include <string>

#include "common/codec/level_codec.h"
#include "common/mesh/operations.h"
#include "common/simplify/preview.h"
#include "server/bake/bake.h"
#include "server/bake/executor.h"
#include "server/bake/shapes.h"
#include "server/bake/stopwatch.h"
#include "server/bake/textures.h"

namespace lodestream::bake {

namespace {

std::string first_level_key(std::uint64_t triangles) {
    return "first/" + std::to_string(triangles);
}

Result<proto::Level> store_preview(store::Store& store, const std::string& asset_id, const mesh::Model& model,
                                   const texture::Textures& textures, const simplify::Preview& preview) {
    const Stopwatch watch;
    const Box bounds = mesh::bounds(model.mesh);
    codec::EncodeOptions options = level_options(bounds, preview.mesh, preview.error);
    options.images = texture::choose(model, textures, level_needs(preview.error)).images;
    const std::vector<std::uint8_t> all_gouraud(preview.mesh.triangles.size(), 1);
    Result<codec::Encoded> encoded = codec::encode_level(model, preview.mesh, all_gouraud, options);
    if (!encoded) return encoded.error();
    const double encode_ms = watch.ms();
    Result<store::StoredFile> file =
        store.put_content(asset_id, first_level_key(encoded->triangles), "glb", encoded->glb);
    if (!file) return file.error();
    return described_level(*encoded, preview.error, bounds, encode_ms, file->hash);
}

}  // namespace

Result<std::vector<proto::Level>> make_first_levels(store::Store& store, const std::string& asset_id,
                                                    const mesh::Model& model, const metric::SurfaceError& off,
                                                    const texture::Textures& textures) {
    std::vector<proto::Level> levels;
    for (simplify::Preview& preview : simplify::make_previews(model.mesh, first_level_triangles, all_cores())) {
        if (preview.mesh.triangles.empty()) continue;
        if (!levels.empty() && preview.mesh.triangles.size() >= levels.back().triangles) continue;
        preview.error = sum(preview.error, off);
        Result<proto::Level> level = store_preview(store, asset_id, model, textures, preview);
        if (!level) return level.error();
        levels.push_back(*std::move(level));
    }
    return levels;
}

}  // namespace lodestream::bake
