// What a result holds, for programs that end with the first error.
#pragma once

#include <stdexcept>
#include <utility>

#include "common/base/result.h"

namespace lodestream::bench {

// Throws std::runtime_error with the error's message.
template <class T>
T value_of(Result<T> result) {
    if (!result) throw std::runtime_error(result.error().message);
    return *std::move(result);
}

}  // namespace lodestream::bench
