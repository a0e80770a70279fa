#include "common/image/jpeg_tables.h"

#include <algorithm>
#include <cstdint>

namespace lodestream::image {
namespace {

constexpr unsigned start_of_image = 0xd8, end_of_image = 0xd9, huffman_tables = 0xc4;

// Reads forward; beyond the end every byte is 0, as it is to stb.
class Cursor {
  public:
    explicit Cursor(std::span<const std::byte> bytes) : rest_(bytes) {}

    bool at_end() const { return rest_.empty(); }
    unsigned byte() {
        if (rest_.empty()) return 0;
        const auto value = std::to_integer<unsigned>(rest_.front());
        rest_ = rest_.subspan(1);
        return value;
    }
    std::size_t word() {
        const unsigned high = byte();
        return high << 8 | byte();
    }
    void skip(std::size_t count) { rest_ = rest_.subspan(std::min(count, rest_.size())); }

    // The code of the next marker, which may have fill bytes before it; 0 at the end. Entropy-coded data, in which 0xff
    // is followed by 0, is passed over.
    unsigned marker() {
        while (!at_end()) {
            if (byte() != 0xff) continue;
            unsigned code = byte();
            while (code == 0xff) code = byte();
            if (code != 0) return code;
        }
        return 0;
    }

  private:
    std::span<const std::byte> rest_;
};

// Of the segment at the cursor, its length included.
bool tables_are_sound(Cursor& cursor) {
    std::ptrdiff_t length = static_cast<std::ptrdiff_t>(cursor.word()) - 2;
    while (length > 0) {
        cursor.byte();  // class and place of the table
        std::size_t symbols = 0;
        for (int bits = 1; bits <= 16; ++bits) symbols += cursor.byte();
        if (symbols > max_huffman_symbols) return false;
        cursor.skip(symbols);
        length -= 17 + static_cast<std::ptrdiff_t>(symbols);
    }
    return true;
}

bool has_no_length(unsigned marker) {
    return marker == 0x01 || (marker >= 0xd0 && marker <= start_of_image);  // TEM, RST0 … RST7, SOI
}

}  // namespace

bool has_sound_huffman_tables(std::span<const std::byte> bytes) {
    Cursor cursor(bytes);
    if (bytes.empty() || bytes.front() != std::byte{0xff} || cursor.marker() != start_of_image) return true;
    while (!cursor.at_end()) {
        const unsigned marker = cursor.marker();
        if (marker == end_of_image) return true;
        if (marker == huffman_tables) {
            if (!tables_are_sound(cursor)) return false;
        } else if (!has_no_length(marker)) {
            const std::size_t length = cursor.word();
            cursor.skip(length < 2 ? 0 : length - 2);
        }
    }
    return true;
}

}  // namespace lodestream::image
