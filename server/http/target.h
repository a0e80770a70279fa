// A request's target taken apart. Private to http.
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "common/base/result.h"

namespace lodestream::http {

struct Target {
    std::string path;                          // percent-decoded
    std::map<std::string, std::string> query;  // percent-decoded, '+' is a space; of a repeated name the first
};

// Origin form, absolute form, or "*". Errors: bad escapes, control characters, text that is not UTF-8.
Result<Target> parse_target(std::string_view text);

}  // namespace lodestream::http
