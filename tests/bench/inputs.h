// The models that are simplified.
#pragma once

#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/mesh/mesh.h"
#include "tests/bench/connectivity.h"

namespace lodestream::bench {

// The same for all methods: oriented, manifold, no attributes but a smooth normal at every vertex.
struct Input {
    std::string name;
    mesh::Mesh mesh;
    Repairs repairs;
};

// A model file; "made:86k", "made:346k", "made:1.4M" or "made:5.5M", the armadillo of `folder` subdivided to so many
// triangles and given detail of their size; or "sample:terrain:40000", a model of server/samples. Errors as
// import_file() and make_sample(), and invalid_input where no triangle is left.
Result<Input> load_input(const std::string& spec, const std::string& folder);

// The specs of the default comparison: the large models below `folder` that exist, and "made:1.4M".
std::vector<std::string> default_inputs(const std::string& folder);

}  // namespace lodestream::bench
