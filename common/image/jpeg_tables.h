// Private to the folder: what stb_image 2.27 does not check of a JPEG itself.
#pragma once

#include <cstddef>
#include <span>

namespace lodestream::image {

inline constexpr std::size_t max_huffman_symbols = 256;  // of one table, by the format

// False where a Huffman table states more symbols than there can be: stb writes as many as are stated, past the end of
// its own table. Anything else that may be wrong with the file is left to stb, and bytes that are no JPEG are fine.
bool has_sound_huffman_tables(std::span<const std::byte> bytes);

}  // namespace lodestream::image
