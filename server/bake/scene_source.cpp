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

template <class T>
void copy(std::span<const T> from, std::uint64_t first, std::uint64_t end, std::vector<T>& to) {
    if (!from.empty())
        to.assign(from.begin() + static_cast<std::ptrdiff_t>(first), from.begin() + static_cast<std::ptrdiff_t>(end));
}

}  // namespace

Result<store::StoredFile> put_scene_source(store::Store& store, const std::string& asset_id, const mesh::Model& model,
                                           std::span<const std::span<const std::uint32_t>> triangles,
                                           const std::vector<std::uint32_t>& tiles) {
    mesh::Mesh all;
    std::vector<Box> boxes;
    std::vector<std::uint64_t> first_vertex{0}, first_triangle{0};
    for (const auto& of_object : triangles) {
        const mesh::Mesh object = mesh::part(model.mesh, of_object);
        const Box box = mesh::bounds(object);
        boxes.push_back(box.empty() ? box : Box{box.min + model.origin, box.max + model.origin});
        all.positions.insert(all.positions.end(), object.positions.begin(), object.positions.end());
        all.normals.insert(all.normals.end(), object.normals.begin(), object.normals.end());
        all.texture_coordinates.insert(all.texture_coordinates.end(), object.texture_coordinates.begin(),
                                       object.texture_coordinates.end());
        all.colors.insert(all.colors.end(), object.colors.begin(), object.colors.end());
        all.triangles.insert(all.triangles.end(), object.triangles.begin(), object.triangles.end());
        all.triangle_materials.insert(all.triangle_materials.end(), object.triangle_materials.begin(),
                                      object.triangle_materials.end());
        first_vertex.push_back(all.positions.size());
        first_triangle.push_back(all.triangles.size());
    }
    Writer writer;
    writer.magic(magic);
    writer(model.materials);
    writer(model.images);
    writer(model.origin);
    writer(model.graph.parents);
    writer(model.graph.object_nodes);
    writer.array(boxes);
    writer.array(tiles);
    writer.array(first_vertex);
    writer.array(first_triangle);
    writer.array(all.positions);
    writer.array(all.normals);
    writer.array(all.texture_coordinates);
    writer.array(all.colors);
    writer.array(all.triangles);
    writer.array(all.triangle_materials);
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
    reader(model_.materials);
    reader(model_.images);
    reader(model_.origin);
    reader(model_.graph.parents);
    reader(model_.graph.object_nodes);
    reader.array(boxes_);
    reader.array(tiles_);
    reader.array(first_vertex_);
    reader.array(first_triangle_);
    reader.array(positions_);
    reader.array(normals_);
    reader.array(texture_coordinates_);
    reader.array(colors_);
    reader.array(triangles_);
    reader.array(triangle_materials_);
    const std::size_t vertices = positions_.size(), objects = tiles_.size();
    const auto is_whole = [](std::size_t size, std::size_t count) { return size == 0 || size == count; };
    const bool sound = reader.ok() && reader.at_end() && is_forest(model_.graph) && !model_.materials.empty() &&
                       all_finite(model_.origin) && model_.graph.object_nodes.size() == objects &&
                       boxes_.size() == objects && is_partition(first_vertex_, objects, vertices) &&
                       is_partition(first_triangle_, objects, triangles_.size()) &&
                       is_whole(normals_.size(), vertices) && is_whole(texture_coordinates_.size(), vertices) &&
                       is_whole(colors_.size(), vertices) && is_whole(triangle_materials_.size(), triangles_.size());
    if (!sound) return damaged();
    return Nothing{};
}

Result<mesh::Mesh> SceneSource::mesh(std::uint32_t object) const {
    const std::uint64_t vertex = first_vertex_[object], vertex_end = first_vertex_[object + 1];
    const std::uint64_t triangle = first_triangle_[object], triangle_end = first_triangle_[object + 1];
    mesh::Mesh mesh;
    copy(positions_, vertex, vertex_end, mesh.positions);
    copy(normals_, vertex, vertex_end, mesh.normals);
    copy(texture_coordinates_, vertex, vertex_end, mesh.texture_coordinates);
    copy(colors_, vertex, vertex_end, mesh.colors);
    copy(triangles_, triangle, triangle_end, mesh.triangles);
    copy(triangle_materials_, triangle, triangle_end, mesh.triangle_materials);
    for (const mesh::Triangle& t : mesh.triangles)
        if (*std::max_element(t.begin(), t.end()) >= mesh.positions.size()) return damaged();
    for (const std::uint32_t material : mesh.triangle_materials)
        if (material >= model_.materials.size()) return damaged();
    return mesh;
}

}  // namespace lodestream::bake
