#include "tests/bench/levels.h"
#include "common/mesh/instances.h"

#include <filesystem>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "common/mesh/operations.h"
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
    return mesh::without_instances(*std::move(model));
}

simplify::History record_history(mesh::Mesh mesh) {
    simplify::RecordOptions options;
    options.executor = bake::all_cores();
    Result<simplify::History> history = simplify::record_history(std::move(mesh), options);
    if (!history) throw std::runtime_error(history.error().message);
    return *std::move(history);
}

mesh::Model model_of(const codec::Decoded& decoded) {
    mesh::Model model;
    model.materials = decoded.materials;
    model.images = decoded.images;
    model.origin = decoded.origin;
    for (const codec::Primitive& primitive : decoded.primitives) {
        mesh::Mesh part = primitive.mesh;
        part.triangle_materials.assign(part.triangles.size(), primitive.material);
        part.colors.resize(part.positions.size(), Rgba8(255));
        part.texture_coordinates.resize(part.positions.size());
        mesh::append(model.mesh, part);
    }
    return model;
}

}  // namespace lodestream::bench
