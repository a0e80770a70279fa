// Models with their materials, and levels of them, for benchmarks of what comes behind simplification.
#pragma once

#include <initializer_list>
#include <string>
#include <vector>

#include "common/codec/level_codec.h"
#include "common/mesh/mesh.h"
#include "common/simplify/history.h"

namespace lodestream::bench {

// Those of the files below a folder that exist.
std::vector<std::string> files_below(const std::string& folder, std::initializer_list<const char*> names);

// A model file, or "sample:NAME", a model of server/samples. Throws std::runtime_error with the reader's message.
mesh::Model load_model(const std::string& spec);

// On all cores. Throws likewise.
simplify::History record_history(mesh::Mesh mesh);

// What a level decodes to as one model.
mesh::Model model_of(const codec::Decoded& decoded);

}  // namespace lodestream::bench
