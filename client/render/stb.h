// stb behind three plain functions; private to this folder.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace lodestream::render {

struct ImageSize {
    int width = 0;  // 0: not a PNG or JPEG
    int height = 0;
};

ImageSize stb_size(const std::uint8_t* data, std::size_t size);
// pre: stb_size() of the same bytes is within the limits
bool stb_decode(const std::uint8_t* data, std::size_t size, std::vector<std::uint8_t>& rgba, std::string& reason);
bool stb_encode_png(int width, int height, const std::uint8_t* rgba, std::vector<std::byte>& png);

}  // namespace lodestream::render
