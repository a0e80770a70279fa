#include "common/image/png_chunks.h"

#include <gtest/gtest.h>

#include <string>

#include "common/image/codec.h"

namespace lodestream::image {
namespace {

std::vector<std::byte> bytes_of(const std::string& text) {
    const auto* first = reinterpret_cast<const std::byte*>(text.data());
    return {first, first + text.size()};
}

// A small PNG, and the same with a chunk of four bytes of the given type after its header.
std::vector<std::byte> plain() {
    return *encode_png({2, 2, std::vector<std::uint8_t>(16, 77)});
}
std::vector<std::byte> with_chunk(const std::string& type) {
    std::vector<std::byte> png = plain();
    const std::vector<std::byte> chunk = bytes_of(std::string("\0\0\0\4", 4) + type + "data" + "crc!");
    png.insert(png.begin() + 8 + 25, chunk.begin(), chunk.end());
    return png;
}

TEST(PixelsOnly, LeavesOutWhatDoesNotMakePixels) {
    for (const char* type : {"gAMA", "cHRM", "iCCP", "sRGB", "pHYs", "tEXt", "tIME", "acTL"})
        EXPECT_EQ(pixels_only(with_chunk(type)), plain()) << type;
}

TEST(PixelsOnly, KeepsTransparencyAndPalette) {
    for (const char* type : {"tRNS", "PLTE"}) EXPECT_EQ(pixels_only(with_chunk(type)), with_chunk(type)) << type;
}

TEST(PixelsOnly, DropsWhatFollowsTheEnd) {
    std::vector<std::byte> png = plain();
    png.push_back(std::byte{1});
    EXPECT_EQ(pixels_only(png), plain());
}

TEST(PixelsOnly, DamagedAndOtherBytesComeBackUnchanged) {
    const std::vector<std::byte> png = with_chunk("gAMA");
    for (std::size_t size = 0; size < png.size(); ++size) {
        const std::vector<std::byte> cut(png.begin(), png.begin() + static_cast<std::ptrdiff_t>(size));
        EXPECT_EQ(pixels_only(cut), cut) << size;
    }
    EXPECT_EQ(pixels_only(bytes_of("no png")), bytes_of("no png"));
    std::vector<std::byte> huge = png;
    huge[33] = std::byte{0xff};  // a length beyond the end
    EXPECT_EQ(pixels_only(huge), huge);
}

}  // namespace
}  // namespace lodestream::image
