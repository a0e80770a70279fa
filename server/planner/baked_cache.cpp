#include "server/planner/baked_cache.h"

#include <algorithm>

#include "common/mesh/operations.h"
#include "server/bake/bake.h"
#include "server/bake/textures.h"

namespace lodestream::planner {

namespace {

Result<std::span<const std::byte>> add_file(LoadedAsset& asset, const store::StoredFile& stored) {
    Result<store::MappedFile> file = store::MappedFile::open(stored.path, max_baked_bytes);
    if (!file) return file.error();
    asset.files.push_back(*std::move(file));
    return asset.files.back().bytes();
}

Status add_shells(LoadedAsset& asset, const store::Store& store, const std::string& asset_id) {
    for (std::size_t i = 0; i < bake::max_shells; ++i) {
        const Result<store::Store::Content> content = store.content(asset_id, bake::shell_key(i));
        if (!content) break;
        const Result<std::span<const std::byte>> bytes = add_file(asset, content->file);
        if (!bytes) return bytes.error();
        Result<bake::ShellView> shell = bake::open_shell(*bytes);
        if (!shell) return shell.error();
        asset.shells.push_back(*std::move(shell));
    }
    return Nothing{};
}

// pre: the asset stays where it is
Status add_colors(LoadedAsset& asset) {
    for (const bake::ShellView& shell : asset.shells) {
        if (shell.colored_by.empty() || asset.colors) continue;
        const std::uint64_t triangles = simplify::triangle_count(asset.baked.history);
        for (const std::uint32_t t : shell.colored_by)
            if (t >= triangles) return invalid_input("a stored shell names a triangle that its scene does not have");
        const mesh::Mesh finest = simplify::cut(asset.baked.history, triangles);
        asset.colors.emplace(asset.baked.model, mesh::part(finest, shell.colored_by));
    }
    return Nothing{};
}

Result<std::shared_ptr<const LoadedAsset>> open_asset(const store::Store& store, const std::string& asset_id,
                                                      const store::StoredFile& stored) {
    const auto asset = std::make_shared<LoadedAsset>();
    const Result<std::span<const std::byte>> bytes = add_file(*asset, stored);
    if (!bytes) return bytes.error();
    Result<bake::BakedView> baked = bake::open_baked_model(*bytes);
    if (!baked) return baked.error();
    asset->baked = *std::move(baked);
    Result<texture::Ladder> ladder = bake::load_textures(store, asset_id, asset->baked.model.images.size());
    if (!ladder) return ladder.error();
    asset->textures = texture::textures_of(*std::move(ladder), asset->baked.image_uses, asset->baked.texel_sizes);
    const Vec3d& origin = asset->baked.model.origin;
    asset->world_bounds = {asset->baked.bounds.min + origin, asset->baked.bounds.max + origin};
    if (Status added = add_shells(*asset, store, asset_id); !added) return added.error();
    if (Status added = add_colors(*asset); !added) return added.error();
    return std::shared_ptr<const LoadedAsset>(asset);
}

}  // namespace

Result<std::shared_ptr<const LoadedAsset>> BakedCache::load(const std::string& asset_id) {
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

    Result<std::shared_ptr<const LoadedAsset>> asset = open_asset(store_, asset_id, content->file);
    if (!asset) return asset;
    std::uint64_t bytes = 0;
    for (const store::MappedFile& file : (*asset)->files) bytes += file.bytes().size();
    entries_.push_front({asset_id, content->file.hash, bytes, *asset});
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
