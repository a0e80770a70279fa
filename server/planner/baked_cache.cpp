#include "server/planner/baked_cache.h"

#include <algorithm>
#include <chrono>

#include "common/mesh/operations.h"
#include "server/bake/textures.h"

namespace lodestream::planner {

LoadedAsset::LoadedAsset(bake::BakedModel model, texture::Ladder ladder)
    : baked(std::move(model)),
      textures(texture::textures_of(baked.model, std::move(ladder))),
      index(baked.model.mesh),
      bounds(mesh::bounds(baked.model.mesh)) {
    world_bounds.min = bounds.min + baked.model.origin;
    world_bounds.max = bounds.max + baked.model.origin;
}

metric::SurfaceError LoadedAsset::error_of(const mesh::Mesh& level, double& measure_ms) {
    measure_ms = 0.0;
    if (level.triangles.size() == baked.model.mesh.triangles.size()) return {};
    const std::uint64_t triangles = level.triangles.size();
    {
        const std::lock_guard lock(mutex_);
        if (const auto known = errors_.find(triangles); known != errors_.end()) return known->second;
    }
    const auto start = std::chrono::steady_clock::now();
    const metric::SurfaceError error = metric::measure(index, baked.model.mesh, level);
    measure_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();

    const std::lock_guard lock(mutex_);
    if (errors_.size() >= max_remembered_errors) errors_.clear();
    errors_.emplace(triangles, error);
    return error;
}

Result<std::shared_ptr<LoadedAsset>> BakedCache::load(const std::string& asset_id) {
    Result<store::Store::Content> content = store_.content(asset_id, bake::baked_key);
    if (!content) return content.error();

    const std::lock_guard lock(mutex_);
    const auto entry =
        std::find_if(entries_.begin(), entries_.end(), [&](const Entry& e) { return e.asset_id == asset_id; });
    if (entry != entries_.end() && entry->hash == content->file.hash) {
        entries_.splice(entries_.begin(), entries_, entry);
        return entry->asset;
    }
    if (entry != entries_.end()) entries_.erase(entry);

    Result<std::vector<std::byte>> bytes = store::read_file(content->file.path, max_baked_bytes);
    if (!bytes) return bytes.error();
    Result<bake::BakedModel> baked = bake::deserialize(*bytes);
    if (!baked) return baked.error();
    Result<texture::Ladder> ladder = bake::load_textures(store_, asset_id, baked->model.images.size());
    if (!ladder) return ladder.error();
    auto asset = std::make_shared<LoadedAsset>(std::move(*baked), std::move(*ladder));
    entries_.push_front({asset_id, content->file.hash, bytes->size() * memory_per_stored_byte, asset});
    make_room();
    return asset;
}

void BakedCache::forget(const std::string& asset_id) {
    const std::lock_guard lock(mutex_);
    entries_.remove_if([&](const Entry& e) { return e.asset_id == asset_id; });
}

void BakedCache::make_room() {
    std::uint64_t used = 0;
    for (const Entry& e : entries_) used += e.bytes;
    while (entries_.size() > 1 && used > max_cached_bytes) {
        used -= entries_.back().bytes;
        entries_.pop_back();
    }
}

}  // namespace lodestream::planner
