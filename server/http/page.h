// The page at "/". Private to http.
#pragma once

#include <string_view>

namespace lodestream::http {

std::string_view index_html();

}  // namespace lodestream::http
