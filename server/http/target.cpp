#include "server/http/target.h"

#include <optional>

namespace lodestream::http {

namespace {

int hex_digit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
}

std::optional<std::string> percent_decode(std::string_view text, bool plus_is_space) {
    std::string decoded;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] == '+' && plus_is_space) {
            decoded += ' ';
        } else if (text[i] != '%') {
            decoded += text[i];
        } else {
            const int high = i + 2 < text.size() ? hex_digit(text[i + 1]) : -1;
            const int low = i + 2 < text.size() ? hex_digit(text[i + 2]) : -1;
            if (high < 0 || low < 0) return std::nullopt;
            decoded += static_cast<char>(high * 16 + low);
            i += 2;
        }
    }
    return decoded;
}

// RFC 3629: no overlong forms, no surrogates, nothing above U+10FFFF; and no control characters.
bool is_plain_utf8(std::string_view text) {
    std::size_t i = 0;
    const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(at < text.size() ? text[at] : 0); };
    while (i < text.size()) {
        const unsigned lead = byte(i);
        if (lead < 0x20 || lead == 0x7f) return false;
        const std::size_t length = lead < 0x80                   ? 1
                                   : lead >= 0xc2 && lead < 0xe0 ? 2
                                   : lead >= 0xe0 && lead < 0xf0 ? 3
                                   : lead >= 0xf0 && lead < 0xf5 ? 4
                                                                 : 0;
        if (length == 0) return false;
        for (std::size_t k = 1; k < length; ++k)
            if ((byte(i + k) & 0xc0u) != 0x80u) return false;
        const unsigned second = byte(i + 1);
        if ((lead == 0xe0 && second < 0xa0) || (lead == 0xed && second > 0x9f) || (lead == 0xf0 && second < 0x90) ||
            (lead == 0xf4 && second > 0x8f))
            return false;
        i += length;
    }
    return true;
}

Result<std::string> decode(std::string_view text, bool plus_is_space) {
    auto decoded = percent_decode(text, plus_is_space);
    if (!decoded) return invalid_input("the target has a broken percent escape");
    if (!is_plain_utf8(*decoded)) return invalid_input("the target is not UTF-8 or has control characters");
    return *std::move(decoded);
}

}  // namespace

Result<Target> parse_target(std::string_view text) {
    for (const std::string_view scheme : {"http://", "https://"})
        if (text.starts_with(scheme)) {
            const auto path = text.find_first_of("/?", scheme.size());
            text = path == std::string_view::npos ? "/" : text.substr(path);
        }
    const auto mark = text.find('?');
    auto path = decode(text.substr(0, mark), false);
    if (!path) return path.error();
    if (path->empty()) *path = "/";
    if (*path != "*" && path->front() != '/') return invalid_input("the target must begin with '/'");
    Target target{*std::move(path), {}};
    std::string_view query = mark == std::string_view::npos ? std::string_view{} : text.substr(mark + 1);
    while (!query.empty()) {
        const auto end = query.find('&');
        const std::string_view item = query.substr(0, end);
        query = end == std::string_view::npos ? std::string_view{} : query.substr(end + 1);
        const auto equals = item.find('=');
        auto name = decode(item.substr(0, equals), true);
        auto value = decode(equals == std::string_view::npos ? std::string_view{} : item.substr(equals + 1), true);
        if (!name) return name.error();
        if (!value) return value.error();
        if (!name->empty()) target.query.emplace(*std::move(name), *std::move(value));
    }
    return target;
}

}  // namespace lodestream::http
