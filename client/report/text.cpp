#include "client/report/text.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>

namespace lodestream::report {
namespace {

constexpr std::string_view replacement = "\xEF\xBF\xBD";  // U+FFFD

struct CodePoint {
    char32_t value = 0;
    std::size_t length = 0;  // bytes; 0: not valid UTF-8
};

bool is_continuation(char c) {
    return (static_cast<unsigned char>(c) & 0xC0u) == 0x80u;
}

CodePoint next_code_point(std::string_view text) {
    const auto lead = static_cast<unsigned char>(text.front());
    if (lead < 0x80) return {lead, 1};
    const std::size_t length = lead >= 0xF0 && lead < 0xF8 ? 4 : lead >= 0xE0 ? 3 : lead >= 0xC0 ? 2 : 0;
    if (length == 0 || lead >= 0xF8 || text.size() < length) return {};
    char32_t value = lead & (0xFFu >> (length + 1));
    for (std::size_t i = 1; i < length; ++i) {
        if (!is_continuation(text[i])) return {};
        value = value << 6 | (static_cast<unsigned char>(text[i]) & 0x3Fu);
    }
    constexpr char32_t smallest[] = {0, 0, 0x80, 0x800, 0x10000};
    const bool surrogate = value >= 0xD800 && value <= 0xDFFF;
    if (value < smallest[length] || value > 0x10FFFF || surrogate) return {};
    return {value, length};
}

bool is_control(char32_t c) {
    const bool control = c < 0x20 || (c >= 0x7F && c < 0xA0);
    const bool direction = (c >= 0x202A && c <= 0x202E) || (c >= 0x2066 && c <= 0x2069) || c == 0x200E || c == 0x200F;
    return control || direction || c == 0x2028 || c == 0x2029;
}

struct CodePointRange {
    char32_t first, last;
};
// The blocks of Unicode's East Asian Width "W" and "F" that names are made of, and emoji.
constexpr CodePointRange wide_ranges[] = {{0x1100, 0x115F}, {0x2E80, 0x303E},   {0x3041, 0xA4CF},  {0xA960, 0xA97F},
                                          {0xAC00, 0xD7A3}, {0xF900, 0xFAFF},   {0xFE30, 0xFE6F},  {0xFF00, 0xFF60},
                                          {0xFFE0, 0xFFE6}, {0x1F300, 0x1FAFF}, {0x20000, 0x3FFFD}};

std::size_t columns_of(char32_t c) {
    if ((c >= 0x0300 && c <= 0x036F) || (c >= 0x200B && c <= 0x200D) || (c >= 0xFE00 && c <= 0xFE0F)) return 0;
    const auto holds = [c](const CodePointRange& range) { return c >= range.first && c <= range.last; };
    return std::any_of(std::begin(wide_ranges), std::end(wide_ranges), holds) ? 2 : 1;
}

std::string print(const char* format, double value) {
    char buffer[64];
    std::snprintf(buffer, sizeof buffer, format, value);
    return buffer;
}

std::string with_thousands(std::string digits) {
    const std::ptrdiff_t first = !digits.empty() && digits.front() == '-' ? 1 : 0;
    for (std::ptrdiff_t at = std::ssize(digits) - 3; at > first; at -= 3)
        digits.insert(static_cast<std::size_t>(at), 1, ',');
    return digits;
}

}  // namespace

std::string printable(std::string_view text) {
    std::string out;
    out.reserve(text.size());
    while (!text.empty()) {
        const CodePoint point = next_code_point(text);
        const std::size_t length = std::max<std::size_t>(point.length, 1);
        out += point.length == 0 || is_control(point.value) ? replacement : text.substr(0, length);
        text.remove_prefix(length);
    }
    return out;
}

std::string escape_html(std::string_view text) {
    std::string out;
    for (const char c : printable(text)) {
        switch (c) {
            case '&':
                out += "&amp;";
                break;
            case '<':
                out += "&lt;";
                break;
            case '>':
                out += "&gt;";
                break;
            case '"':
                out += "&quot;";
                break;
            case '\'':
                out += "&#39;";
                break;
            default:
                out += c;
        }
    }
    return out;
}

std::size_t terminal_columns(std::string_view utf8) {
    std::size_t columns = 0;
    while (!utf8.empty()) {
        const CodePoint point = next_code_point(utf8);
        columns += columns_of(point.value);
        utf8.remove_prefix(std::max<std::size_t>(point.length, 1));
    }
    return columns;
}

std::string_view terminal_prefix(std::string_view utf8, std::size_t columns) {
    std::string_view rest = utf8;
    while (!rest.empty()) {
        const CodePoint point = next_code_point(rest);
        const std::size_t needed = columns_of(point.value);
        if (needed > columns) break;
        columns -= needed;
        rest.remove_prefix(std::max<std::size_t>(point.length, 1));
    }
    return utf8.substr(0, utf8.size() - rest.size());
}

std::string file_stem(std::string_view name) {
    constexpr std::size_t max_length = 64;
    std::string out;
    for (const char c : name.substr(0, max_length)) {
        const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
        const bool safe = letter || (c >= '0' && c <= '9') || c == '-' || c == '_' || c == '.';
        out += safe ? c : '_';
    }
    if (out.empty()) return "asset";
    if (out.front() == '.') out.front() = '_';
    return out;
}

std::string format_count(std::uint64_t count) {
    return with_thousands(std::to_string(count));
}

std::string format_number(double value) {
    if (!std::isfinite(value)) return "–";
    if (value == 0.0) return "0";
    const double size = std::abs(value);
    if (size < 1e-4 || size >= 1e15) return print("%.1e", value);
    if (size >= 999.5) return with_thousands(print("%.0f", value));
    if (size >= 99.95) return print("%.0f", value);
    return print("%.3g", value);
}

std::string format_bytes(double bytes) {
    if (!std::isfinite(bytes)) return "–";
    if (bytes < 1000) return print("%.0f bytes", bytes);
    if (bytes < 999'500) return format_number(bytes / 1e3) + " KB";
    return format_number(bytes / 1e6) + " MB";
}

std::string format_duration(double milliseconds) {
    if (!std::isfinite(milliseconds)) return "–";
    return milliseconds < 1000 ? format_number(milliseconds) + " ms" : format_number(milliseconds / 1e3) + " s";
}

std::string base64(std::string_view bytes) {
    constexpr std::string_view alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    out.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t at = 0; at < bytes.size(); at += 3) {
        const std::string_view group = bytes.substr(at, 3);
        std::uint32_t bits = 0;
        for (std::size_t i = 0; i < 3; ++i)
            bits = bits << 8 | (i < group.size() ? static_cast<unsigned char>(group[i]) : 0u);
        for (std::size_t i = 0; i < 4; ++i) out += i <= group.size() ? alphabet[bits >> (18 - 6 * i) & 63u] : '=';
    }
    return out;
}

}  // namespace lodestream::report
