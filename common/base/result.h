// An expected failure is a value: Result<T> holds either a T or an Error, and in both cases the warnings met on the
// way. A bug is an assertion. Nothing is thrown across a library's border.
#pragma once

#include <cassert>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace lodestream {

enum class ErrorCode {
    invalid_input,   // the caller's data or request is wrong; saying so helps the caller (HTTP 400 or 422)
    unsupported,     // well formed, but a feature or format that is not handled (415)
    limit_exceeded,  // larger than a named limit (413)
    not_found,       // no such asset, file or content (404)
    conflict,        // the name is taken or the state forbids it (409)
    unauthorized,    // a token is needed (401)
    unavailable,     // not now: baking, overloaded or stopping (503)
    io,              // disk or network failed
    internal         // a check of our own results failed
};

struct Error {
    ErrorCode code = ErrorCode::internal;
    std::string message;  // one line: what is wrong and where
};

template <class T>
class [[nodiscard]] Result {
  public:
    Result(T value) : value_(std::move(value)) {}      // NOLINT(google-explicit-constructor)
    Result(Error error) : error_(std::move(error)) {}  // NOLINT(google-explicit-constructor)

    bool ok() const { return value_.has_value(); }
    explicit operator bool() const { return ok(); }

    // pre: ok()
    T& value() & {
        assert(ok());
        return *value_;
    }
    const T& value() const& {
        assert(ok());
        return *value_;
    }
    T&& value() && {
        assert(ok());
        return *std::move(value_);
    }
    T& operator*() & { return value(); }
    const T& operator*() const& { return value(); }
    T&& operator*() && { return std::move(*this).value(); }
    T* operator->() { return &value(); }
    const T* operator->() const { return &value(); }

    // pre: !ok()
    const Error& error() const {
        assert(!ok());
        return error_;
    }

    std::vector<std::string> warnings;

  private:
    std::optional<T> value_;
    Error error_;
};

struct Nothing {};
using Status = Result<Nothing>;

inline Error fail(ErrorCode code, std::string message) {
    return Error{code, std::move(message)};
}
inline Error invalid_input(std::string message) {
    return fail(ErrorCode::invalid_input, std::move(message));
}

}  // namespace lodestream
