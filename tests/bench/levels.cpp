#include "tests/bench/levels.h"

#include <stdexcept>
#include <string_view>
#include <utility>

#include "server/bake/executor.h"
#include "server/importer/importer.h"
#include "server/samples/samples.h"

namespace lodestream::bench {

mesh::Model load_model(const std::string& spec) {
    constexpr std::string_view sample = "sample:";
    Result<mesh::Model> model =
        spec.starts_with(sample) ? samples::make_sample(spec.substr(sample.size())) : importer::import_file(spec);
    if (!model) throw std::runtime_error(model.error().message);
    return *std::move(model);
}

simplify::History record_history(mesh::Mesh mesh) {
    simplify::RecordOptions options;
    options.executor = bake::all_cores();
    Result<simplify::History> history = simplify::record_history(std::move(mesh), options);
    if (!history) throw std::runtime_error(history.error().message);
    return *std::move(history);
}

}  // namespace lodestream::bench
