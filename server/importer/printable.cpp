#include "server/importer/printable.h"

#include <string_view>

namespace lodestream::importer {
namespace {

unsigned byte_at(std::string_view text, std::size_t i) {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0;
}

// Bytes of the well-formed UTF-8 sequence that begins at `i`; 0 where none does.
std::size_t sequence_length(std::string_view text, std::size_t i) {
    const unsigned first = byte_at(text, i), second = byte_at(text, i + 1);
    const auto continues = [&](std::size_t k) { return (byte_at(text, k) & 0xc0u) == 0x80; };
    if (first < 0x80) return 1;
    if (first >= 0xc2 && first <= 0xdf) return continues(i + 1) ? 2 : 0;
    const bool overlong = (first == 0xe0 && second < 0xa0) || (first == 0xf0 && second < 0x90);
    const bool outside = (first == 0xed && second > 0x9f) || (first == 0xf4 && second > 0x8f);
    if (overlong || outside || first < 0xe0 || first > 0xf4) return 0;
    const std::size_t length = first < 0xf0 ? 3 : 4;
    for (std::size_t k = 1; k < length; ++k)
        if (!continues(i + k)) return 0;
    return length;
}

bool is_utf8(std::string_view text) {
    for (std::size_t i = 0; i < text.size();) {
        const std::size_t length = sequence_length(text, i);
        if (length == 0) return false;
        i += length;
    }
    return true;
}

}  // namespace

std::string printable(std::string text) {
    const bool keep_wide = is_utf8(text);
    for (char& c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (byte < 0x20 || byte == 0x7f || (byte >= 0x80 && !keep_wide)) c = '?';
    }
    return text;
}

}  // namespace lodestream::importer
