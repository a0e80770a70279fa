#include "server/bake/textures.h"

#include <sstream>

namespace lodestream::bake {

namespace {

constexpr std::uint64_t max_texture_bytes = 256ull << 20;

std::string texture_key(std::size_t image, std::size_t rung) {
    return "image/" + std::to_string(image) + "/" + std::to_string(rung);
}

// What a stored image's bytes do not say in a word, kept beside them.
std::string record_of(const texture::SmallerImage& smaller) {
    std::ostringstream record;
    record << smaller.halvings << ' ' << smaller.image.width << ' ' << smaller.image.height << ' '
           << smaller.image.media_type;
    return record.str();
}

Result<texture::SmallerImage> read_texture(const store::Store::Content& content) {
    texture::SmallerImage smaller;
    std::istringstream record(content.record);
    record >> smaller.halvings >> smaller.image.width >> smaller.image.height >> smaller.image.media_type;
    if (!record) return fail(ErrorCode::internal, "the record of a stored texture is damaged");
    Result<std::vector<std::byte>> bytes = store::read_file(content.file.path, max_texture_bytes);
    if (!bytes) return bytes.error();
    smaller.image.bytes = *std::move(bytes);
    return smaller;
}

}  // namespace

texture::Needs level_needs(const metric::SurfaceError& error) {
    texture::Needs needs;
    needs.pixel_size = error.max / shown_error_px;
    return needs;
}

Status put_textures(store::Store& store, const std::string& asset_id, const texture::Ladder& ladder) {
    for (std::size_t image = 0; image < ladder.size(); ++image)
        for (std::size_t rung = 0; rung < ladder[image].size(); ++rung) {
            const texture::SmallerImage& smaller = ladder[image][rung];
            const char* extension = smaller.image.media_type == "image/png" ? "png" : "jpg";
            if (auto file = store.put_content(asset_id, texture_key(image, rung), extension, smaller.image.bytes,
                                              record_of(smaller));
                !file)
                return file.error();
        }
    return Nothing{};
}

Result<texture::Ladder> load_textures(const store::Store& store, const std::string& asset_id, std::size_t images) {
    texture::Ladder ladder(images);
    for (std::size_t image = 0; image < images; ++image)
        for (std::size_t rung = 0;; ++rung) {
            const Result<store::Store::Content> content = store.content(asset_id, texture_key(image, rung));
            if (!content && content.error().code == ErrorCode::not_found) break;
            if (!content) return content.error();
            Result<texture::SmallerImage> smaller = read_texture(*content);
            if (!smaller) return smaller.error();
            ladder[image].push_back(*std::move(smaller));
        }
    return ladder;
}

}  // namespace lodestream::bake
