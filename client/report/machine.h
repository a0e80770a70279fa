// Where measurements come from.
#pragma once

#include <string>

#include "client/report/data.h"

namespace lodestream::report {

// The command, the commit that was built, this moment and this machine; nothing of a renderer.
Provenance provenance_of(std::string command);
// Those of a benchmark.
Provenance provenance_of(const proto::RunOrigin& origin);

// The same as one line of HTML, for below a table.
std::string source_line(const Provenance& from);

// The command line as typed.
std::string joined(int argc, const char* const* argv);

}  // namespace lodestream::report
