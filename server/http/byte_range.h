// The conditional and partial requests of RFC 9110: If-None-Match, If-Range and Range. Private to http.
#pragma once

#include <cstdint>
#include <string_view>

namespace lodestream::http {

// Whether a field of entity tags names `etag` (with its quotes), weakly compared; "*" names all.
bool names_etag(std::string_view field, std::string_view etag);

struct RangeAnswer {
    enum class Kind { whole, part, unsatisfiable };
    Kind kind = Kind::whole;
    std::uint64_t offset = 0;
    std::uint64_t length = 0;
};

// What a Range field asks of `size` bytes. Several ranges, other units and syntax errors mean the whole.
RangeAnswer answer_range(std::string_view field, std::uint64_t size);

}  // namespace lodestream::http
