#include "server/planner/baked_cache.h"

#include <algorithm>

#include "server/bake/bake.h"
#include "server/bake/textures.h"

namespace lodestream::planner {

namespace {

Result<std::shared_ptr<const LoadedAsset>> open_asset(const store::Store& store, const std::string& asset_id,
                                                      const store::StoredFile& stored) {
    Result<store::MappedFile> file = store::MappedFile::open(stored.path, max_baked_bytes);
    if (!file) return file.error();
    Result<bake::BakedView> baked = bake::open_baked_model(file->bytes());
    if (!baked) return baked.error();
    Result<texture::Ladder> ladder = bake::load_textures(store, asset_id, baked->model.images.size());
    if (!ladder) return ladder.error();
    texture::Textures textures = texture::textures_of(*std::move(ladder), baked->image_uses, baked->texel_sizes);
    const Box world{baked->bounds.min + baked->model.origin, baked->bounds.max + baked->model.origin};
    return std::make_shared<const LoadedAsset>(
        LoadedAsset{*std::move(file), *std::move(baked), std::move(textures), world});
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
    entries_.push_front({asset_id, content->file.hash, content->file.bytes, *asset});
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
