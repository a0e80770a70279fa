// The stored form of a scene's objects: magic "LODOBJS1", then the fields below in order, as stored_form.h says. All
// arrays are those of the objects one behind the other.
#include "server/bake/scene_source.h"

#include <algorithm>

#include "common/mesh/operations.h"
#include "server/bake/source_model.h"
#include "server/bake/stored_form.h"

namespace lodestream::bake {

namespace {

constexpr std::string_view magic = "LODOBJS1";

Error damaged() {
    return invalid_input("the stored objects are damaged");
}

// Whether it rises from 0 to `end`.
bool is_partition(std::span<const std::uint64_t> first, std::size_t objects, std::size_t end) {
    return first.size() == objects + 1 && first.front() == 0 && first.back() == end &&
           std::is_sorted(first.begin(), first.end());
}

template <class Stream, class Model, class Arrays>
void describe(Stream& stream, Model& model, Arrays& arrays) {
    stream(model.materials);
    stream(model.images);
    stream(model.origin);
    stream(model.graph.parents);
    stream(model.graph.object_nodes);
    stream.array(arrays.boxes);
    stream.array(arrays.tiles);
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

}  // namespace

Result<store::StoredFile> put_scene_source(store::Store& store, const std::string& asset_id, const mesh::Model& model,
                                           std::span<const std::span<const std::uint32_t>> triangles,
                                           const std::vector<std::uint32_t>& tiles) {
    ObjectArrays<simplify::OwnedArray> all;
    all.tiles = tiles;
    all.first_vertex = all.first_triangle = {0};
    for (const auto& of_object : triangles) {
        const mesh::Mesh object = mesh::part(model.mesh, of_object);
        const Box box = mesh::bounds(object);
        all.boxes.push_back(box.empty() ? box : Box{box.min + model.origin, box.max + model.origin});
        all.positions.insert(all.positions.end(), object.positions.begin(), object.positions.end());
        all.normals.insert(all.normals.end(), object.normals.begin(), object.normals.end());
        all.texture_coordinates.insert(all.texture_coordinates.end(), object.texture_coordinates.begin(),
                                       object.texture_coordinates.end());
        all.colors.insert(all.colors.end(), object.colors.begin(), object.colors.end());
        all.triangles.insert(all.triangles.end(), object.triangles.begin(), object.triangles.end());
        all.triangle_materials.insert(all.triangle_materials.end(), object.triangle_materials.begin(),
                                      object.triangle_materials.end());
        all.first_vertex.push_back(all.positions.size());
        all.first_triangle.push_back(all.triangles.size());
    }
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
    Reader reader(file_.bytes());
    if (!reader.magic(magic)) return damaged();
    describe(reader, model_, arrays_);
    const std::size_t vertices = arrays_.positions.size(), objects = arrays_.tiles.size();
    const auto is_whole = [](std::size_t size, std::size_t count) { return size == 0 || size == count; };
    const bool sound = reader.ok() && reader.at_end() && is_forest(model_.graph) && !model_.materials.empty() &&
                       all_finite(model_.origin) && model_.graph.object_nodes.size() == objects &&
                       arrays_.boxes.size() == objects && is_partition(arrays_.first_vertex, objects, vertices) &&
                       is_partition(arrays_.first_triangle, objects, arrays_.triangles.size()) &&
                       is_whole(arrays_.normals.size(), vertices) &&
                       is_whole(arrays_.texture_coordinates.size(), vertices) &&
                       is_whole(arrays_.colors.size(), vertices) &&
                       is_whole(arrays_.triangle_materials.size(), arrays_.triangles.size());
    if (!sound) return damaged();
    return Nothing{};
}

Result<mesh::Mesh> SceneSource::mesh(std::uint32_t object) const {
    const std::uint64_t vertex = arrays_.first_vertex[object], vertex_end = arrays_.first_vertex[object + 1];
    const std::uint64_t triangle = arrays_.first_triangle[object], triangle_end = arrays_.first_triangle[object + 1];
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
    return mesh;
}

}  // namespace lodestream::bake
