#include "server/live/tile_contents.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "common/base/transform.h"
#include "common/codec/level_codec.h"
#include "common/mesh/operations.h"
#include "common/scene/lod_tree.h"
#include "server/bake/tile_levels.h"

namespace lodestream::live {

namespace {

Box at_origin(const Box& box, const Vec3d& origin) {
    return box.empty() ? box : Box{box.min + origin, box.max + origin};
}

Result<Content> store_content(TransientFiles& files, const codec::Encoded& encoded, const Box& box, double error) {
    Result<TransientFiles::Kept> kept = files.put(encoded.glb);
    if (!kept) return kept.error();
    return Content{kept->file.hash, kept->file.bytes, encoded.triangles, error, box, std::move(kept->keeper)};
}

// Whether the grid resolves its mesh as finely as it is meant to.
bool is_fine(const codec::QuantizationGrid& grid, const mesh::Mesh& mesh) {
    return grid.step() * codec::coarsest_steps_per_edge <= mesh::mean_edge_length(mesh);
}

template <class T>
void fill(std::vector<T>& values, std::size_t size, const T& value, bool is_needed) {
    if (is_needed && values.size() < size) values.resize(size, value);
}

// What several contents show, as one model; materials and images that are alike are there once.
class Joined {
  public:
    explicit Joined(const Vec3d& origin) { model_.origin = origin; }

    // `matrix`: from the content's coordinates to where it is now.
    void add(const codec::Decoded& content, const Mat4d& matrix) {
        std::vector<std::uint32_t> materials;
        for (const mesh::Material& material : content.materials) materials.push_back(add(material, content.images));
        const Mat4d from_content = translation(-model_.origin) * matrix * translation(content.origin);
        const bool stays = from_content == Mat4d(1.0);
        for (const codec::Primitive& primitive : content.primitives) {
            mesh::Mesh mesh = stays ? primitive.mesh : mesh::placed(primitive.mesh, Vec3d(0.0), from_content);
            mesh.triangle_materials.assign(mesh.triangles.size(), materials[primitive.material]);
            append(std::move(mesh));
        }
    }

    // Without triangles that lie on others.
    mesh::Model finish() && {
        mesh::Mesh& mesh = model_.mesh;
        mesh = mesh::compact(mesh::part(mesh, mesh::distinct_triangles(mesh)));
        return std::move(model_);
    }

  private:
    std::uint32_t add(mesh::Material material, const std::vector<mesh::Image>& images) {
        for (mesh::TextureReference* texture : {&material.base_color_texture, &material.metallic_roughness_texture,
                                                &material.occlusion_texture, &material.emissive_texture})
            if (texture->image >= 0) texture->image = add(images[static_cast<std::size_t>(texture->image)]);
        model_.materials.push_back(std::move(material));
        return static_cast<std::uint32_t>(model_.materials.size() - 1);
    }

    int add(const mesh::Image& image) {
        const auto same = [&](const mesh::Image& other) { return other.bytes == image.bytes; };
        const auto found = std::find_if(model_.images.begin(), model_.images.end(), same);
        const auto index = found - model_.images.begin();
        if (found == model_.images.end()) model_.images.push_back(image);
        return static_cast<int>(index);
    }

    // Gives both the attributes that either has.
    void append(mesh::Mesh mesh) {
        mesh::Mesh& all = model_.mesh;
        const auto even_out = [](mesh::Mesh& one, const mesh::Mesh& other) {
            const std::size_t size = one.positions.size();
            fill(one.normals, size, Vec3f(0.0f, 1.0f, 0.0f), !other.normals.empty());
            fill(one.texture_coordinates, size, Vec2f(0.0f), !other.texture_coordinates.empty());
            fill(one.colors, size, Rgba8(255), !other.colors.empty());
        };
        if (!all.positions.empty()) even_out(all, mesh);
        if (!all.positions.empty()) even_out(mesh, all);
        mesh::append(all, mesh);
    }

    mesh::Model model_;
};

Result<mesh::Model> join(const store::Store& store, const Vec3d& origin, std::span<const PlacedContent> contents) {
    Joined joined(origin);
    for (const PlacedContent& placed : contents) {
        if (!placed.placement.visible || placed.content.triangles == 0) continue;
        const Result<StoredLevel> stored = read_level(store, placed.content.hash);
        if (!stored) return stored.error();
        const Result<codec::Decoded> content = codec::decode_level(stored->glb);
        if (!content) return content.error();
        joined.add(*content, placed.placement.matrix * placed.content.matrix);
    }
    return std::move(joined).finish();
}

bool is_painted(const mesh::Model& model) {
    return std::any_of(model.materials.begin(), model.materials.end(),
                       [](const mesh::Material& material) { return material.name == bake::painted_name; });
}

}  // namespace

Result<StoredLevel> read_level(const store::Store& store, const std::string& hash) {
    Result<store::StoredFile> file = store.file(hash, "glb");
    if (!file) return file.error();
    Result<std::vector<std::byte>> glb = store::read_file(file->path, max_tile_bytes);
    if (!glb) return glb.error();
    return StoredLevel{*std::move(file), *std::move(glb)};
}

Result<Content> content_of(const store::StoredFile& file, std::span<const std::byte> glb, double error) {
    const Result<codec::Decoded> decoded = codec::decode_level(glb);
    if (!decoded) return decoded.error();
    Content content{file.hash, file.bytes, 0, error, {}, nullptr};
    for (const codec::Primitive& primitive : decoded->primitives) {
        const Box box = at_origin(mesh::bounds(primitive.mesh), decoded->origin);
        content.triangles += primitive.mesh.triangles.size();
        if (box.empty()) continue;
        content.box.add(box.min);
        content.box.add(box.max);
    }
    if (content.triangles == 0) return invalid_input("a level without triangles");
    return content;
}

Result<ObjectsContent> make_objects_content(TransientFiles& files, const bake::SceneSource& source,
                                            std::span<const PlacedObject> objects) {
    const mesh::Model& model = source.model();
    bake::Surface surface;
    for (const PlacedObject& placed : objects) {
        if (!placed.placement.visible) continue;
        Result<mesh::Mesh> mesh = source.mesh(placed.object);
        if (!mesh) return mesh.error();
        mesh::append(surface.mesh, placed.placement.matrix == Mat4d(1.0)
                                       ? *mesh
                                       : mesh::placed(*std::move(mesh), model.origin, placed.placement.matrix));
    }
    surface.mesh = mesh::compact(surface.mesh);
    ObjectsContent out;
    if (surface.mesh.triangles.empty()) return out;
    const codec::QuantizationGrid grid = bake::tile_grid(surface.mesh, {});
    out.is_exact = is_fine(grid, surface.mesh);
    const Result<codec::Encoded> encoded = bake::encode_tile(surface, {}, grid, model, {}, nullptr);
    if (!encoded) return encoded.error();
    Result<Content> content = store_content(files, *encoded, at_origin(mesh::bounds(surface.mesh), model.origin), 0.0);
    if (!content) return content.error();
    out.content = *std::move(content);
    return out;
}

Result<std::vector<Content>> make_levels_above(TransientFiles& files, const store::Store& store,
                                               const mesh::Model& source, std::span<const PlacedContent> below,
                                               std::size_t count, bool is_root, const std::function<bool()>& goes_on) {
    Result<mesh::Model> joined = join(store, source.origin, below);
    if (!joined) return joined.error();
    double error_below = 0.0;
    for (const PlacedContent& placed : below)
        if (placed.placement.visible)
            error_below = std::max(error_below, placed.content.error * scene::largest_scale(placed.placement.matrix));

    const std::vector<std::uint64_t> counts = bake::tile_counts(joined->mesh.triangles.size(), is_root);
    const bool is_bare = is_painted(*joined),
               may_paint = bake::can_be_painted(source.materials) &&
                           bake::can_be_painted(joined->materials);  // of added objects too
    const bake::Surface whole{is_bare ? bake::bare(joined->mesh) : joined->mesh, is_bare};
    bake::SeenSurface seen = bake::seen_from_outside(whole, counts.front(), may_paint);
    std::optional<bake::SceneColors> colors;
    if (may_paint) colors.emplace(*joined, mesh::part(joined->mesh, seen.triangles));
    Result<std::vector<bake::TileLevel>> levels =
        bake::cut_levels(std::move(seen), counts, scene::max_tree_triangles, {}, goes_on);
    if (!levels) return levels.error();

    std::vector<Content> contents;
    for (const bake::TileLevel& level : *levels) {
        if (contents.size() == count) break;
        const mesh::Mesh& mesh = level.surface.mesh;
        const codec::QuantizationGrid grid = bake::tile_grid(mesh, level.error);
        const Result<codec::Encoded> encoded =
            bake::encode_tile(level.surface, level.error, grid, *joined, {}, colors ? &*colors : nullptr);
        if (!encoded) return encoded.error();
        const double error = level.error.max + error_below + bake::rounding_error(grid);
        Result<Content> content = store_content(files, *encoded, at_origin(mesh::bounds(mesh), source.origin), error);
        if (!content) return content.error();
        contents.push_back(*std::move(content));
    }
    while (contents.size() < count) contents.push_back(contents.back());
    return contents;
}

}  // namespace lodestream::live
