#include "server/http/byte_range.h"

#include <algorithm>
#include <charconv>
#include <limits>
#include <optional>

namespace lodestream::http {

namespace {

std::string_view trim(std::string_view text) {
    const auto first = text.find_first_not_of(" \t");
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

// Digits alone; a number too large for 64 bits is as good as the largest.
std::optional<std::uint64_t> parse_position(std::string_view text) {
    if (text.empty() || !std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; }))
        return std::nullopt;
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() ? value : std::numeric_limits<std::uint64_t>::max();
}

RangeAnswer part(std::uint64_t offset, std::uint64_t length) {
    return {length > 0 ? RangeAnswer::Kind::part : RangeAnswer::Kind::unsatisfiable, offset, length};
}

}  // namespace

bool names_etag(std::string_view field, std::string_view etag) {
    while (!field.empty()) {
        const auto comma = field.find(',');
        std::string_view item = trim(field.substr(0, comma));
        if (item.starts_with("W/")) item.remove_prefix(2);
        if (item == "*" || item == etag) return true;
        field = comma == std::string_view::npos ? std::string_view{} : field.substr(comma + 1);
    }
    return false;
}

RangeAnswer answer_range(std::string_view field, std::uint64_t size) {
    constexpr std::string_view unit = "bytes=";
    if (!field.starts_with(unit)) return {};
    const std::string_view range = trim(field.substr(unit.size()));
    const auto dash = range.find('-');
    if (dash == std::string_view::npos || range.find(',') != std::string_view::npos) return {};
    const auto first = parse_position(range.substr(0, dash));
    const auto last = parse_position(range.substr(dash + 1));
    if (dash == 0) {
        if (!last) return {};
        const std::uint64_t length = std::min(*last, size);
        return part(size - length, length);
    }
    if (!first || (!last && dash + 1 != range.size()) || (last && *last < *first)) return {};
    if (*first >= size) return {RangeAnswer::Kind::unsatisfiable, 0, 0};
    return part(*first, std::min(last.value_or(size - 1), size - 1) - *first + 1);
}

}  // namespace lodestream::http
