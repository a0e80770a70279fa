#include "server/importer/soup.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/transform.h"
#include "common/mesh/operations.h"
#include "common/scene/placement.h"
#include "server/importer/polygon.h"
#include "server/importer/printable.h"

namespace lodestream::importer {
namespace {

constexpr std::size_t max_warnings = 100;
constexpr std::uint64_t max_clipping_work = 400'000'000;  // corner tests a file, about a second

// Beyond it a coordinate counts as not finite: it leaves room for sums and differences in float.
constexpr double max_coordinate = std::numeric_limits<float>::max() / 16.0;
// A model whose centre is more than this many of its sizes away from the world's origin gets an origin of its own.
constexpr double far_away_sizes = 4.0;

bool usable(const Vec3d& p) {
    return std::abs(p.x) <= max_coordinate && std::abs(p.y) <= max_coordinate && std::abs(p.z) <= max_coordinate;
}

bool is_zero(const Vec3f& v) {
    return v.x == 0 && v.y == 0 && v.z == 0;
}

Vec3f unit_or_zero(const Vec3f& v) {
    if (!all_finite(v)) return Vec3f{0};
    const Vec3d wide(v);
    const double size = std::max({std::abs(wide.x), std::abs(wide.y), std::abs(wide.z)});
    return size > 0 ? Vec3f(glm::normalize(wide / size)) : Vec3f{0};
}

// Keeps the triangles that `keep` accepts and returns how many went.
template <class Keep>
std::uint64_t keep_triangles(Soup& soup, Keep keep) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
        if (!keep(soup.triangles[i])) continue;
        soup.triangles[kept] = soup.triangles[i];
        soup.triangle_objects[kept] = soup.triangle_objects[i];
        soup.triangle_materials[kept++] = soup.triangle_materials[i];
    }
    const std::uint64_t dropped = soup.triangles.size() - kept;
    soup.triangles.resize(kept);
    soup.triangle_materials.resize(kept);
    soup.triangle_objects.resize(kept);
    return dropped;
}

double rounded_to_step(double value, double size) {
    const double exponent = std::floor(std::log10(size));
    // Dividing by a whole power of ten gives the shortest decimal; multiplying by 0.001 does not.
    if (exponent >= 0) return std::round(value / std::pow(10.0, exponent)) * std::pow(10.0, exponent);
    return std::round(value * std::pow(10.0, -exponent)) / std::pow(10.0, -exponent);
}

Vec3d origin_of(const Box& box) {
    const Vec3d center = box.center(), extent = box.extent();
    const double size = std::max({extent.x, extent.y, extent.z});
    const double away = std::max({std::abs(center.x), std::abs(center.y), std::abs(center.z)});
    if (!(size > 0) || away <= far_away_sizes * size) return Vec3d{0};
    const Vec3d origin{rounded_to_step(center.x, size), rounded_to_step(center.y, size),
                       rounded_to_step(center.z, size)};
    return all_finite(origin) ? origin + Vec3d{0} : Vec3d{0};  // no -0
}

bool is_of_shape(const Soup& soup, std::size_t triangle) {
    return soup.triangle_objects[triangle] >= Soup::first_shape;
}

Vec3d choose_origin(const Soup& soup) {
    Box box;
    std::vector<Box> shapes(soup.shapes);
    for (std::size_t t = 0; t < soup.triangles.size(); ++t) {
        Box& around = is_of_shape(soup, t) ? shapes[soup.triangle_objects[t] - Soup::first_shape] : box;
        for (const std::uint32_t v : soup.triangles[t]) around.add(soup.positions[v]);
    }
    for (const SoupInstance& instance : soup.instances) {
        const Box placed = scene::placed(shapes[instance.shape], instance.to_world);
        if (placed.empty()) continue;
        box.add(placed.min);
        box.add(placed.max);
    }
    return origin_of(box);
}

// From the model's origin, those of shapes from their own.
void move_positions(const Soup& soup, mesh::Model& model) {
    std::vector<bool> is_shape(soup.shapes > 0 ? soup.positions.size() : 0);
    if (soup.shapes > 0)
        for (std::size_t t = 0; t < soup.triangles.size(); ++t)
            for (const std::uint32_t v : soup.triangles[t]) is_shape[v] = is_of_shape(soup, t);
    model.mesh.positions.reserve(soup.positions.size());
    for (std::size_t v = 0; v < soup.positions.size(); ++v) {
        const Vec3d origin = !is_shape.empty() && is_shape[v] ? Vec3d{0} : model.origin;
        model.mesh.positions.emplace_back(usable(soup.positions[v]) ? soup.positions[v] - origin : Vec3d{0});
    }
}

template <class T>
void free_memory(std::vector<T>& v) {
    std::vector<T>().swap(v);
}

void move_attributes(Soup& soup, mesh::Mesh& mesh) {
    const std::size_t n = mesh.positions.size();
    if (!soup.normals.empty()) {
        soup.normals.resize(n, Vec3f{0});
        for (Vec3f& normal : soup.normals) normal = unit_or_zero(normal);
        mesh.normals = std::move(soup.normals);
    }
    if (!soup.texture_coordinates.empty()) {
        soup.texture_coordinates.resize(n, Vec2f{0});
        for (Vec2f& t : soup.texture_coordinates)
            if (!std::isfinite(t.x) || !std::isfinite(t.y)) t = Vec2f{0};
        mesh.texture_coordinates = std::move(soup.texture_coordinates);
    }
    if (!soup.colors.empty()) {
        soup.colors.resize(n, Rgba8{255});
        mesh.colors = std::move(soup.colors);
    }
}

void move_objects(Soup& soup, mesh::Model& model) {
    model.objects = static_cast<std::uint32_t>(std::clamp<std::uint64_t>(soup.objects, 1, 0xffffffff));
    if (model.objects == 1) return;
    model.mesh.triangle_objects = std::move(soup.triangle_objects);
    model.graph = std::move(soup.graph);
    if (model.graph.parents.empty()) model.graph = mesh::flat_graph(model.objects);
}

// The part of `mesh` whose triangles `take` picks.
template <class Take>
mesh::Mesh part_of(const mesh::Mesh& mesh, Take take) {
    std::vector<std::uint32_t> taken;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
        if (take(mesh.triangles[t])) taken.push_back(t);
    return mesh::part(mesh, taken);
}

mesh::Mesh made_normals(mesh::Mesh mesh) {
    mesh.normals.clear();
    // A soup of separate triangles is several times smaller welded; indexed meshes are not.
    const bool is_soup = mesh.positions.size() > mesh.triangles.size();
    return mesh::with_normals(is_soup ? mesh::compact(mesh) : mesh, crease_degrees);
}

// Compact, with normals where the file has none: for the whole mesh, or for the triangles with a corner that lacks one.
mesh::Mesh finished(mesh::Mesh mesh) {
    if (mesh.normals.empty()) return made_normals(std::move(mesh));
    const auto complete = [&](const mesh::Triangle& t) {
        return std::none_of(t.begin(), t.end(), [&](std::uint32_t v) { return is_zero(mesh.normals[v]); });
    };
    const auto lacking = [&](const mesh::Triangle& t) { return !complete(t); };
    if (std::all_of(mesh.triangles.begin(), mesh.triangles.end(), complete)) return mesh::compact(mesh);
    if (std::none_of(mesh.triangles.begin(), mesh.triangles.end(), complete)) return made_normals(std::move(mesh));
    mesh::Mesh all = part_of(mesh, complete);
    mesh::append(all, made_normals(part_of(mesh, lacking)));
    return mesh::compact(all);
}

// Out of the mesh; instances whose shape has no triangles are left out.
void take_shapes(const Soup& soup, mesh::Model& model) {
    if (soup.shapes == 0) return;
    std::vector<std::vector<std::uint32_t>> triangles(soup.shapes);
    std::vector<std::uint32_t> rest;
    for (std::uint32_t t = 0; t < model.mesh.triangles.size(); ++t) {
        const std::uint32_t object = model.mesh.triangle_objects[t];
        (object >= Soup::first_shape ? triangles[object - Soup::first_shape] : rest).push_back(t);
    }
    std::vector<std::uint32_t> places(soup.shapes);
    for (std::uint32_t shape = 0; shape < soup.shapes; ++shape) {
        places[shape] = static_cast<std::uint32_t>(model.shapes.size());
        if (triangles[shape].empty()) continue;
        model.shapes.push_back(mesh::part(model.mesh, triangles[shape]));
        model.shapes.back().triangle_objects.clear();
    }
    for (const SoupInstance& instance : soup.instances)
        if (!triangles[instance.shape].empty())
            model.instances.push_back(
                {instance.object, places[instance.shape], translation(-model.origin) * instance.to_world});
    model.mesh = mesh::part(model.mesh, rest);
}

// Only the materials that triangles use and the images that those use, in the order of the source.
void keep_used_materials(mesh::Model& model) {
    if (model.materials.empty()) model.materials.emplace_back();
    std::vector<std::uint32_t> place(model.materials.size(), 0);
    for (const std::uint32_t m : model.mesh.triangle_materials) place[m] = 1;
    if (model.mesh.triangle_materials.empty()) place[0] = 1;
    std::vector<mesh::Material> used;
    for (std::size_t m = 0; m < place.size(); ++m) {
        if (!place[m]) continue;
        place[m] = static_cast<std::uint32_t>(used.size());
        used.push_back(std::move(model.materials[m]));
    }
    for (std::uint32_t& m : model.mesh.triangle_materials) m = place[m];
    model.materials = std::move(used);
    if (model.materials.size() == 1) model.mesh.triangle_materials.clear();
}

template <class Visit>
void for_each_texture(std::vector<mesh::Material>& materials, Visit visit) {
    for (mesh::Material& m : materials)
        for (mesh::TextureReference* t :
             {&m.base_color_texture, &m.metallic_roughness_texture, &m.occlusion_texture, &m.emissive_texture})
            if (t->image >= 0) visit(*t);
}

void keep_used_images(mesh::Model& model, std::vector<mesh::Image>& images, std::vector<std::string>& warnings) {
    if (model.mesh.texture_coordinates.empty()) {
        bool dropped = false;
        for_each_texture(model.materials, [&](mesh::TextureReference& t) {
            t.image = -1;
            dropped = true;
        });
        if (dropped) warnings.push_back("textures dropped: the mesh has no texture coordinates");
    }
    std::vector<int> place(images.size(), -1);
    for_each_texture(model.materials, [&](mesh::TextureReference& t) {
        int& at = place[static_cast<std::size_t>(t.image)];
        if (at < 0) {
            at = static_cast<int>(model.images.size());
            model.images.push_back(std::move(images[static_cast<std::size_t>(t.image)]));
        }
        t.image = at;
    });
}

std::string counted(std::uint64_t n, const char* one, const char* many) {
    return std::to_string(n) + " " + (n == 1 ? one : many);
}

std::string left_out(std::uint64_t points_and_lines) {
    return counted(points_and_lines, "point or line", "points and lines") + " left out";
}

Result<mesh::Model> with_printable_warnings(mesh::Model model, std::vector<std::string> warnings) {
    Result<mesh::Model> result(std::move(model));
    for (std::string& warning : warnings) result.warnings.push_back(printable(std::move(warning)));
    return result;
}

Error nothing_left(const Soup& soup, std::uint64_t read_triangles) {
    const std::uint64_t faces = read_triangles + soup.unreadable_faces + soup.out_of_range_faces;
    if (faces > 0)
        return invalid_input("has " + counted(faces, "face", "faces") +
                             " but none is a triangle of three different finite points");
    const std::uint64_t points = std::max<std::uint64_t>(soup.positions.size(), soup.other_primitives);
    if (points > 0) return invalid_input("has " + counted(points, "point", "points") + " but no triangles");
    return invalid_input("has no geometry");
}

bool is_cloud(const Soup& soup) {
    return soup.may_be_cloud && soup.triangles.empty() && soup.unreadable_faces + soup.out_of_range_faces == 0;
}

// The points that are finite, with their attributes, and no triangles.
Result<mesh::Model> finish_cloud(Soup soup) {
    mesh::Model model;
    model.kind = mesh::Kind::points;
    model.materials.emplace_back();
    Box box;
    for (const Vec3d& p : soup.positions)
        if (usable(p)) box.add(p);
    if (box.empty()) return invalid_input("has no point with finite coordinates");
    model.origin = origin_of(box);
    const std::size_t read = soup.positions.size();
    mesh::Mesh all;
    all.positions.resize(read);
    move_attributes(soup, all);
    for (std::size_t i = 0; i < read; ++i) {
        if (!usable(soup.positions[i])) continue;
        model.mesh.positions.emplace_back(soup.positions[i] - model.origin);
        if (!all.normals.empty()) model.mesh.normals.push_back(all.normals[i]);
        if (!all.colors.empty()) model.mesh.colors.push_back(all.colors[i]);
    }
    const auto is_missing = [](const Vec3f& normal) { return normal == Vec3f{0}; };
    std::vector<Vec3f>& normals = model.mesh.normals;
    if (std::any_of(normals.begin(), normals.end(), is_missing)) {
        normals.clear();
        soup.warnings.push_back("normals left out: some points have none");
    }
    if (soup.other_primitives > 0) soup.warnings.push_back(left_out(soup.other_primitives));
    const std::uint64_t dropped = read - model.mesh.positions.size();
    if (dropped > 0) soup.warnings.push_back(counted(dropped, "point", "points") + " dropped: coordinates not finite");
    return with_printable_warnings(std::move(model), std::move(soup.warnings));
}

}  // namespace

std::uint32_t Soup::add_vertex(const Vec3d& position) {
    positions.push_back(position);
    return static_cast<std::uint32_t>(positions.size() - 1);
}

std::uint32_t Soup::copy_vertex(std::uint32_t vertex) {
    const std::uint32_t copy = add_vertex(Vec3d(positions[vertex]));
    if (vertex < normals.size()) set_normal(copy, Vec3f(normals[vertex]));
    if (vertex < texture_coordinates.size()) set_texture_coordinate(copy, Vec2f(texture_coordinates[vertex]));
    if (vertex < colors.size()) set_color(copy, Rgba8(colors[vertex]));
    return copy;
}

void Soup::set_normal(std::uint32_t vertex, const Vec3f& normal) {
    if (normals.size() <= vertex) normals.resize(vertex + std::size_t{1}, Vec3f{0});
    normals[vertex] = normal;
}

void Soup::set_texture_coordinate(std::uint32_t vertex, const Vec2f& coordinate) {
    if (texture_coordinates.size() <= vertex) texture_coordinates.resize(vertex + std::size_t{1}, Vec2f{0});
    texture_coordinates[vertex] = coordinate;
}

void Soup::set_color(std::uint32_t vertex, const Rgba8& color) {
    if (colors.size() <= vertex) colors.resize(vertex + std::size_t{1}, Rgba8{255});
    colors[vertex] = color;
}

void Soup::add_polygon(std::span<const std::uint32_t> corners, std::uint32_t material) {
    if (corners.size() == 3) return add_triangle({corners[0], corners[1], corners[2]}, material);
    if (corners.size() < 3) {
        ++unreadable_faces;
        return;
    }
    // A corner on top of the one before makes no edge; outlines often close by repeating the first.
    polygon_.clear();
    std::vector<Vec3d> outline;
    for (const std::uint32_t corner : corners)
        if (polygon_.empty() || positions[corner] != outline.back()) {
            polygon_.push_back(corner);
            outline.push_back(positions[corner]);
        }
    while (polygon_.size() > 3 && outline.back() == outline.front()) {
        polygon_.pop_back();
        outline.pop_back();
    }
    if (polygon_.size() < 3) {
        add_triangle({corners[0], corners[1], corners[2]}, material);  // counted as degenerate later
        return;
    }
    cut_.clear();
    if (std::all_of(outline.begin(), outline.end(), usable))
        triangulate(outline, cut_, clipping_work_, max_clipping_work);
    else
        for (std::uint32_t i = 1; i + 1 < outline.size(); ++i) cut_.push_back({0, i, i + 1});
    if (clipping_work_ > max_clipping_work) warn("polygons too intricate to cut exactly were cut as fans");
    for (const auto& [a, b, c] : cut_) add_triangle({polygon_[a], polygon_[b], polygon_[c]}, material);
}

void Soup::warn(const std::string& text) {
    if (warnings.size() == max_warnings) warnings.push_back("further warnings left out");
    if (warnings.size() > max_warnings) return;
    if (std::find(warnings.begin(), warnings.end(), text) == warnings.end()) warnings.push_back(text);
}

Status admit(std::uint64_t vertices, std::uint64_t triangles, const Limits& limits) {
    if (vertices > limits.vertices)
        return fail(
            ErrorCode::limit_exceeded,
            "has " + std::to_string(vertices) + " vertices, more than the limit of " + std::to_string(limits.vertices));
    if (triangles > limits.triangles)
        return fail(ErrorCode::limit_exceeded, "has " + std::to_string(triangles) +
                                                   " triangles, more than the limit of " +
                                                   std::to_string(limits.triangles));
    return Nothing{};
}

float linear_from_srgb(float srgb) {
    return srgb <= 0.04045f ? srgb / 12.92f : std::pow((srgb + 0.055f) / 1.055f, 2.4f);
}

Rgba8 quantized(const Vec4f& linear) {
    Rgba8 out;
    for (int i = 0; i < 4; ++i) {
        const float v = linear[i];
        out[i] = !(v > 0) ? std::uint8_t{0} : static_cast<std::uint8_t>(std::lround(std::min(v, 1.0f) * 255.0f));
    }
    return out;
}

Rgba8 linear_from_srgb(const Vec4f& srgb) {
    return quantized({linear_from_srgb(srgb.x), linear_from_srgb(srgb.y), linear_from_srgb(srgb.z), srgb.w});
}

Result<mesh::Model> finish(Soup soup, const Limits& limits) {
    if (is_cloud(soup) && !soup.positions.empty()) return finish_cloud(std::move(soup));
    const std::uint64_t read_triangles = soup.triangles.size();
    const std::uint64_t not_finite = keep_triangles(soup, [&](const mesh::Triangle& t) {
        return std::all_of(t.begin(), t.end(), [&](std::uint32_t v) { return usable(soup.positions[v]); });
    });

    mesh::Model model;
    model.kind = soup.kind;
    model.origin = choose_origin(soup);
    move_positions(soup, model);
    const std::uint64_t degenerate = keep_triangles(soup, [&, &p = model.mesh.positions](const mesh::Triangle& t) {
        return p[t[0]] != p[t[1]] && p[t[1]] != p[t[2]] && p[t[2]] != p[t[0]];
    });
    if (soup.triangles.empty()) return nothing_left(soup, read_triangles);

    free_memory(soup.positions);
    move_attributes(soup, model.mesh);
    model.mesh.triangles = std::move(soup.triangles);
    model.mesh.triangle_materials = std::move(soup.triangle_materials);
    move_objects(soup, model);
    model.materials = std::move(soup.materials);
    keep_used_materials(model);
    keep_used_images(model, soup.images, soup.warnings);
    take_shapes(soup, model);
    std::uint64_t vertices = 0, triangles = 0;
    const auto finish_mesh = [&](mesh::Mesh& mesh) {
        if (!mesh.triangles.empty()) mesh = finished(std::move(mesh));
        vertices += mesh.positions.size();
        triangles += mesh.triangles.size();
    };
    finish_mesh(model.mesh);
    std::ranges::for_each(model.shapes, finish_mesh);
    if (const Status fits = admit(vertices, triangles, limits); !fits) return fits.error();

    const auto dropped = [&](std::uint64_t n, const char* why) {
        if (n > 0) soup.warnings.push_back(counted(n, "face", "faces") + " dropped: " + why);
    };
    dropped(not_finite, "coordinates not finite");
    dropped(degenerate, "fewer than three different positions");
    dropped(soup.out_of_range_faces, "vertex index out of range");
    dropped(soup.unreadable_faces, "fewer than three readable corners");
    if (soup.other_primitives > 0) soup.warnings.push_back(left_out(soup.other_primitives));
    for (mesh::Material& material : model.materials) material.name = printable(std::move(material.name));
    return with_printable_warnings(std::move(model), std::move(soup.warnings));
}

}  // namespace lodestream::importer
