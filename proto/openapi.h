// proto/openapi.yaml as JSON, embedded at build time; served at /openapi.json.
#pragma once

#include <string_view>

namespace lodestream::proto {

std::string_view openapi_json();

}  // namespace lodestream::proto
