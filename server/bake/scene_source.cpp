// The stored form of a scene's objects: magic "LODOBJS2", then the fields below in order, as stored_form.h says.
// "LODOBJS1" is the same without meshes and matrices, and still read.
#include "server/bake/scene_source.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "common/mesh/instances.h"
#include "common/mesh/operations.h"
#include "common/scene/placement.h"
#include "server/bake/source_model.h"
#include "server/bake/stored_form.h"

namespace lodestream::bake {

namespace {

constexpr std::string_view magic = "LODOBJS2", older_magic = "LODOBJS1";

Error damaged() {
    return invalid_input("the stored objects are damaged");
}

// Whether it rises from 0 to `end`.
bool is_partition(std::span<const std::uint64_t> first, std::size_t size, std::size_t end) {
    return first.size() == size && size > 0 && first.front() == 0 && first.back() == end &&
           std::is_sorted(first.begin(), first.end());
}

template <class Stream, class Model, class Arrays>
void describe(Stream& stream, Model& model, Arrays& arrays, bool is_older = false) {
    stream(model.materials);
    stream(model.images);
    stream(model.origin);
    stream(model.graph.parents);
    stream(model.graph.object_nodes);
    stream.array(arrays.boxes);
    stream.array(arrays.tiles);
    if (!is_older) stream.array(arrays.meshes);
    if (!is_older) stream.array(arrays.matrices);
    stream.array(arrays.first_vertex);
    stream.array(arrays.first_triangle);
    stream.array(arrays.positions);
    stream.array(arrays.normals);
    stream.array(arrays.texture_coordinates);
    stream.array(arrays.colors);
    stream.array(arrays.triangles);
    stream.array(arrays.triangle_materials);
}

template <class T>
void copy(std::span<const T> from, std::uint64_t first, std::uint64_t end, std::vector<T>& to) {
    if (!from.empty())
        to.assign(from.begin() + static_cast<std::ptrdiff_t>(first), from.begin() + static_cast<std::ptrdiff_t>(end));
}

// Puts it behind those before.
void add_mesh(ObjectArrays<simplify::OwnedArray>& all, const mesh::Mesh& mesh) {
    const auto join = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
    join(all.positions, mesh.positions);
    join(all.normals, mesh.normals);
    join(all.texture_coordinates, mesh.texture_coordinates);
    join(all.colors, mesh.colors);
    join(all.triangles, mesh.triangles);
    join(all.triangle_materials, mesh.triangle_materials);
    all.first_vertex.push_back(all.positions.size());
    all.first_triangle.push_back(all.triangles.size());
}

Box in_world(const Box& box, const mesh::Model& model) {
    return box.empty() ? box : Box{box.min + model.origin, box.max + model.origin};
}

void add_instances(ObjectArrays<simplify::OwnedArray>& all, const mesh::Model& model) {
    if (model.instances.empty()) return;
    const auto objects = static_cast<std::uint32_t>(all.boxes.size());
    all.meshes.resize(objects);
    std::iota(all.meshes.begin(), all.meshes.end(), 0u);
    all.matrices.assign(objects, Mat4d(1.0));
    for (const mesh::Mesh& shape : model.shapes) add_mesh(all, shape);
    for (const mesh::Instance& instance : model.instances) {
        all.boxes[instance.object] = in_world(mesh::bounds(model.shapes[instance.shape], instance), model);
        all.meshes[instance.object] = objects + instance.shape;
        all.matrices[instance.object] = instance.matrix;
    }
}

}  // namespace

Result<store::StoredFile> put_scene_source(store::Store& store, const std::string& asset_id, const mesh::Model& model,
                                           std::span<const std::span<const std::uint32_t>> triangles,
                                           const std::vector<std::uint32_t>& tiles) {
    ObjectArrays<simplify::OwnedArray> all;
    all.tiles = tiles;
    all.first_vertex = all.first_triangle = {0};
    for (const auto& of_object : triangles) {
        const mesh::Mesh object = mesh::part(model.mesh, of_object);
        all.boxes.push_back(in_world(mesh::bounds(object), model));
        add_mesh(all, object);
    }
    add_instances(all, model);
    Writer writer;
    writer.magic(magic);
    describe(writer, model, all);
    return store.put_content(asset_id, objects_key, "objects", writer.bytes);
}

Result<SceneSource> SceneSource::open(const store::Store& store, const std::string& asset_id) {
    const Result<store::Store::Content> content = store.content(asset_id, objects_key);
    if (!content) return content.error();
    Result<store::MappedFile> file = store::MappedFile::open(content->file.path, content->file.bytes);
    if (!file) return file.error();
    SceneSource source(*std::move(file));
    if (Status read = source.read(); !read) return read.error();
    return source;
}

Status SceneSource::read() {
    const bool is_older = Reader(file_.bytes()).magic(older_magic);
    Reader reader(file_.bytes());
    if (!reader.magic(magic) && !is_older) return damaged();
    describe(reader, model_, arrays_, is_older);
    const std::size_t vertices = arrays_.positions.size(), objects = arrays_.tiles.size();
    const std::size_t ends = arrays_.meshes.empty() ? objects + 1 : arrays_.first_vertex.size();
    const auto is_whole = [](std::size_t size, std::size_t count) { return size == 0 || size == count; };
    const bool sound = reader.ok() && reader.at_end() && is_forest(model_.graph) && !model_.materials.empty() &&
                       all_finite(model_.origin) && model_.graph.object_nodes.size() == objects &&
                       arrays_.boxes.size() == objects && is_partition(arrays_.first_vertex, ends, vertices) &&
                       is_partition(arrays_.first_triangle, ends, arrays_.triangles.size()) &&
                       is_whole(arrays_.normals.size(), vertices) &&
                       is_whole(arrays_.texture_coordinates.size(), vertices) &&
                       is_whole(arrays_.colors.size(), vertices) &&
                       is_whole(arrays_.triangle_materials.size(), arrays_.triangles.size()) &&
                       is_whole(arrays_.meshes.size(), objects) && is_whole(arrays_.matrices.size(), objects) &&
                       std::ranges::all_of(arrays_.meshes, [&](std::uint32_t mesh) { return mesh < ends - 1; });
    if (!sound) return damaged();
    for (const Mat4d& matrix : arrays_.matrices)
        if (!scene::validate({matrix, true})) return damaged();
    return Nothing{};
}

Result<mesh::Mesh> SceneSource::mesh(std::uint32_t object) const {
    const std::size_t at = arrays_.meshes.empty() ? object : arrays_.meshes[object];
    const std::uint64_t vertex = arrays_.first_vertex[at], vertex_end = arrays_.first_vertex[at + 1];
    const std::uint64_t triangle = arrays_.first_triangle[at], triangle_end = arrays_.first_triangle[at + 1];
    mesh::Mesh mesh;
    copy(arrays_.positions, vertex, vertex_end, mesh.positions);
    copy(arrays_.normals, vertex, vertex_end, mesh.normals);
    copy(arrays_.texture_coordinates, vertex, vertex_end, mesh.texture_coordinates);
    copy(arrays_.colors, vertex, vertex_end, mesh.colors);
    copy(arrays_.triangles, triangle, triangle_end, mesh.triangles);
    copy(arrays_.triangle_materials, triangle, triangle_end, mesh.triangle_materials);
    for (const mesh::Triangle& t : mesh.triangles)
        if (*std::max_element(t.begin(), t.end()) >= mesh.positions.size()) return damaged();
    for (const std::uint32_t material : mesh.triangle_materials)
        if (material >= model_.materials.size()) return damaged();
    if (arrays_.matrices.empty() || arrays_.matrices[object] == Mat4d(1.0)) return mesh;
    return mesh::placed(std::move(mesh), Vec3d(0.0), arrays_.matrices[object]);
}

}  // namespace lodestream::bake
