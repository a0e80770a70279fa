#include "tests/bench/inputs.h"
#include "common/mesh/instances.h"

#include <filesystem>
#include <map>

#include "common/mesh/operations.h"
#include "server/importer/importer.h"
#include "server/samples/samples.h"
#include "tests/bench/subdivide.h"

namespace lodestream::bench {

namespace {

namespace fs = std::filesystem;

constexpr double smooth_degrees = 180.0;
constexpr const char* large_spec = "made:1.4M";
constexpr const char* made_base = "classic/armadillo_86k.obj";
constexpr const char* sample_prefix = "sample:";
constexpr double made_roughness = 0.07;  // the folds between neighbours are then as sharp as in the full dragon scan

// One normal a position, so that vertices that were split stay so: with_normals() would join them again.
std::vector<Vec3f> smooth_normals(const mesh::Mesh& mesh) {
    const mesh::Mesh smooth = mesh::with_normals(mesh, smooth_degrees);
    std::vector<Vec3f> positions = mesh.positions;
    positions.insert(positions.end(), smooth.positions.begin(), smooth.positions.end());
    const std::vector<std::uint32_t> first = mesh::weld_positions(positions);
    std::vector<Vec3f> normals(mesh.positions.size());
    for (std::size_t k = 0; k < smooth.positions.size(); ++k)
        normals[first[mesh.positions.size() + k]] = smooth.normals[k];
    for (std::size_t v = 0; v < normals.size(); ++v) normals[v] = normals[first[v]];
    return normals;
}

Result<Input> prepared(const std::string& name, const mesh::Mesh& mesh) {
    Input input{name, {}, {}};
    input.mesh = make_manifold(mesh, input.repairs);
    if (input.mesh.triangles.empty()) return invalid_input(name + ": nothing of it is manifold");
    input.mesh.normals = smooth_normals(input.mesh);
    return input;
}

Result<Input> load_file(const fs::path& file) {
    Result<mesh::Model> model = importer::import_file(file);
    if (!model) return model.error();
    return prepared(file.stem().string(), mesh::without_instances(*std::move(model)).mesh);
}

// How often the base is subdivided for each made model.
const std::map<std::string, int>& made_steps() {
    static const std::map<std::string, int> steps{{"made:86k", 0}, {"made:346k", 1}, {large_spec, 2}, {"made:5.5M", 3}};
    return steps;
}

Result<Input> make_detailed(const std::string& spec, const std::string& folder) {
    const Result<Input> base = load_file(fs::path(folder) / made_base);
    if (!base) return base.error();
    return prepared(spec, detailed(base->mesh, made_steps().at(spec), made_roughness, 1));
}

}  // namespace

Result<Input> load_input(const std::string& spec, const std::string& folder) {
    if (made_steps().contains(spec)) return make_detailed(spec, folder);
    if (!spec.starts_with(sample_prefix)) return load_file(spec);
    const Result<mesh::Model> model = samples::make_sample(spec.substr(std::string(sample_prefix).size()));
    if (!model) return model.error();
    return prepared(spec, model->mesh);
}

std::vector<std::string> default_inputs(const std::string& folder) {
    std::vector<std::string> specs;
    for (const char* name :
         {"classic/bunny_69k.ply", "classic/armadillo_86k.obj", "classic/nefertiti_100k.obj", "classic/lucy_100k.ply",
          "classic/buddha_100k.obj", "scan/turbineblade_199k.ply", "terrain/stubai_10m.ply", "classic/dragon_871k.ply"})
        if (const fs::path file = fs::path(folder) / name; fs::exists(file)) specs.push_back(file.string());
    if (fs::exists(fs::path(folder) / made_base)) specs.emplace_back(large_spec);
    return specs;
}

}  // namespace lodestream::bench
