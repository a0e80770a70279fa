#pragma once

#include <string>

namespace lodestream::importer {

// Names out of hostile files, fit for one line of a report and for JSON: control characters become '?', and so do all
// bytes beyond ASCII where the text is not valid UTF-8.
std::string printable(std::string text);

}  // namespace lodestream::importer
