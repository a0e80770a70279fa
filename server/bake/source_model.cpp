// The stored form of an imported model: magic "LODMODL3", then the fields below in order, as stored_form.h says.
// "LODMODL2" is the same without shapes and instances, and still read.
#include "server/bake/source_model.h"

#include <algorithm>

#include "common/scene/placement.h"
#include "server/bake/stored_form.h"

namespace lodestream::bake {

namespace {

constexpr std::string_view magic = "LODMODL3", older_magic = "LODMODL2";

template <class Stream, class Mesh>
void describe_mesh(Stream& stream, Mesh& mesh) {
    stream(mesh.positions);
    stream(mesh.normals);
    stream(mesh.texture_coordinates);
    stream(mesh.colors);
    stream(mesh.triangles);
    stream(mesh.triangle_materials);
    stream(mesh.triangle_objects);
}

template <class Stream, class Model>
void describe_model(Stream& stream, Model& model) {
    stream(model.materials);
    stream(model.images);
    stream(model.origin);
    stream(model.kind);
    stream(model.objects);
    describe_mesh(stream, model.mesh);
    stream(model.graph.parents);
    stream(model.graph.object_nodes);
}

// An instance without gaps.
struct StoredInstance {
    std::uint64_t object, shape;
    Mat4d matrix;
};

void write_instances(Writer& writer, const mesh::Model& model) {
    writer(static_cast<std::uint64_t>(model.shapes.size()));
    for (const mesh::Mesh& shape : model.shapes) describe_mesh(writer, shape);
    std::vector<StoredInstance> instances;
    for (const mesh::Instance& instance : model.instances)
        instances.push_back({instance.object, instance.shape, instance.matrix});
    writer(instances);
}

void read_instances(Reader& reader, mesh::Model& model) {
    std::uint64_t shapes = 0;
    reader(shapes);
    for (std::uint64_t i = 0; i < shapes && reader.ok(); ++i) describe_mesh(reader, model.shapes.emplace_back());
    std::vector<StoredInstance> instances;
    reader(instances);
    for (const auto& [object, shape, matrix] : instances)
        model.instances.push_back({static_cast<std::uint32_t>(object), static_cast<std::uint32_t>(shape), matrix});
}

template <class T>
bool is_empty_or(const std::vector<T>& values, std::size_t size) {
    return values.empty() || values.size() == size;
}

bool all_below(const std::vector<std::uint32_t>& values, std::size_t size) {
    return std::all_of(values.begin(), values.end(), [&](std::uint32_t value) { return value < size; });
}

bool is_sound(const mesh::Mesh& mesh, std::size_t materials, std::size_t objects) {
    const std::size_t vertices = mesh.positions.size();
    const auto finite = [](const auto& vector) { return all_finite(vector); };
    return is_empty_or(mesh.normals, vertices) && is_empty_or(mesh.texture_coordinates, vertices) &&
           is_empty_or(mesh.colors, vertices) && is_empty_or(mesh.triangle_materials, mesh.triangles.size()) &&
           std::all_of(mesh.positions.begin(), mesh.positions.end(), finite) &&
           std::all_of(mesh.triangles.begin(), mesh.triangles.end(),
                       [&](const mesh::Triangle& t) { return *std::max_element(t.begin(), t.end()) < vertices; }) &&
           is_empty_or(mesh.triangle_objects, mesh.triangles.size()) && all_below(mesh.triangle_objects, objects) &&
           all_below(mesh.triangle_materials, materials);
}

bool is_sound(const mesh::Model& model) {
    const std::size_t materials = model.materials.size(), objects = model.graph.object_nodes.size();
    const auto is_sound_shape = [&](const mesh::Mesh& shape) { return is_sound(shape, materials, 0); };
    const auto is_sound_instance = [&](const mesh::Instance& instance) {
        return instance.shape < model.shapes.size() && instance.object < objects &&
               scene::validate({instance.matrix, true}).ok();
    };
    return materials > 0 && all_finite(model.origin) && is_forest(model.graph) &&
           is_sound(model.mesh, materials, objects) && std::ranges::all_of(model.shapes, is_sound_shape) &&
           std::ranges::all_of(model.instances, is_sound_instance);
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
    write_instances(writer, model);
    return std::move(writer.bytes);
}

Result<mesh::Model> open_source_model(std::span<const std::byte> bytes) {
    const bool is_older = Reader(bytes).magic(older_magic);
    Reader reader(bytes);
    mesh::Model model;
    const bool is_model = reader.magic(magic) || is_older;
    if (is_model) describe_model(reader, model);
    if (is_model && !is_older) read_instances(reader, model);
    if (!is_model || !reader.ok() || !reader.at_end() || !is_sound(model))
        return invalid_input("the stored model is damaged");
    return model;
}

}  // namespace lodestream::bake
