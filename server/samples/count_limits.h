// The check that every sample makes of its count.
#pragma once

#include <optional>
#include <string>

#include "common/base/result.h"

namespace lodestream::samples {

inline std::optional<Error> outside(const std::string& what, std::uint64_t count, std::uint64_t least,
                                    std::uint64_t most) {
    const std::string range =
        what + " must be " + std::to_string(least) + " to " + std::to_string(most) + ", not " + std::to_string(count);
    if (count < least) return invalid_input(range);
    if (count > most) return fail(ErrorCode::limit_exceeded, range);
    return std::nullopt;
}

}  // namespace lodestream::samples
