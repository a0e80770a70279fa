// gzip (RFC 1952), the content coding that every HTTP client reads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "common/base/result.h"

namespace lodestream::proto {

// Whether an Accept-Encoding field takes it (RFC 9110, 12.5.3): by its name, or by *, with a weight above 0.
bool accepts_gzip(std::string_view accept_encoding);

// The first `deflated` bytes compressed, the others, which are so already, stored.
std::string gzip(std::string_view bytes, std::size_t deflated);
inline std::string gzip(std::string_view bytes) {
    return gzip(bytes, bytes.size());
}

// The bytes are hostile. Errors: invalid_input (no gzip, damaged, cut off, or something behind it), limit_exceeded
// (would give more than max_bytes).
Result<std::string> gunzip(std::string_view bytes, std::uint64_t max_bytes);

}  // namespace lodestream::proto
