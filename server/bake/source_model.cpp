// The stored form of an imported model: magic "LODMODL2", then the fields below in order, as stored_form.h says.
#include "server/bake/source_model.h"

#include <algorithm>

#include "server/bake/stored_form.h"

namespace lodestream::bake {

namespace {

constexpr std::string_view magic = "LODMODL2";

template <class Stream, class Model>
void describe_model(Stream& stream, Model& model) {
    stream(model.materials);
    stream(model.images);
    stream(model.origin);
    stream(model.kind);
    stream(model.objects);
    auto& mesh = model.mesh;
    stream(mesh.positions);
    stream(mesh.normals);
    stream(mesh.texture_coordinates);
    stream(mesh.colors);
    stream(mesh.triangles);
    stream(mesh.triangle_materials);
    stream(mesh.triangle_objects);
    stream(model.graph.parents);
    stream(model.graph.object_nodes);
}

template <class T>
bool is_empty_or(const std::vector<T>& values, std::size_t size) {
    return values.empty() || values.size() == size;
}

bool all_below(const std::vector<std::uint32_t>& values, std::size_t size) {
    return std::all_of(values.begin(), values.end(), [&](std::uint32_t value) { return value < size; });
}

bool is_sound(const mesh::Model& model) {
    const mesh::Mesh& mesh = model.mesh;
    const std::size_t vertices = mesh.positions.size();
    const auto finite = [](const auto& vector) { return all_finite(vector); };
    return is_empty_or(mesh.normals, vertices) && is_empty_or(mesh.texture_coordinates, vertices) &&
           is_empty_or(mesh.colors, vertices) && is_empty_or(mesh.triangle_materials, mesh.triangles.size()) &&
           !model.materials.empty() && all_finite(model.origin) &&
           std::all_of(mesh.positions.begin(), mesh.positions.end(), finite) &&
           std::all_of(mesh.triangles.begin(), mesh.triangles.end(),
                       [&](const mesh::Triangle& t) { return *std::max_element(t.begin(), t.end()) < vertices; }) &&
           is_empty_or(mesh.triangle_objects, mesh.triangles.size()) && is_forest(model.graph) &&
           all_below(mesh.triangle_objects, model.graph.object_nodes.size()) &&
           all_below(mesh.triangle_materials, model.materials.size());
}

}  // namespace

bool is_forest(const mesh::SceneGraph& graph) {
    for (std::size_t node = 0; node < graph.parents.size(); ++node)
        if (graph.parents[node] >= node && graph.parents[node] != mesh::no_parent) return false;
    return all_below(graph.object_nodes, graph.parents.size());
}

std::vector<std::byte> serialize(const mesh::Model& model) {
    Writer writer;
    writer.magic(magic);
    describe_model(writer, model);
    return std::move(writer.bytes);
}

Result<mesh::Model> open_source_model(std::span<const std::byte> bytes) {
    Reader reader(bytes);
    mesh::Model model;
    const bool is_model = reader.magic(magic);
    if (is_model) describe_model(reader, model);
    if (!is_model || !reader.ok() || !reader.at_end() || !is_sound(model))
        return invalid_input("the stored model is damaged");
    return model;
}

}  // namespace lodestream::bake
