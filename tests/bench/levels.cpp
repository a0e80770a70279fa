#include "tests/bench/levels.h"

#include <filesystem>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "server/bake/executor.h"
#include "server/importer/importer.h"
#include "server/samples/samples.h"

namespace lodestream::bench {

std::vector<std::string> files_below(const std::string& folder, std::initializer_list<const char*> names) {
    std::vector<std::string> files;
    for (const char* name : names)
        if (const auto file = std::filesystem::path(folder) / name; std::filesystem::exists(file))
            files.push_back(file.string());
    return files;
}

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
