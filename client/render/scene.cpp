#include "client/render/scene.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <utility>

namespace lodestream::render {
namespace {

constexpr double max_eye_distance = 1e7;    // radii; from there an object is below a pixel in every allowed picture
constexpr double near_share_of_far = 1e-4;  // bounds how far near and far may be apart for a 24-bit depth buffer
constexpr double farthest_offset = 1e12;    // radii; keeps what is worked out from it finite
constexpr float largest_sum = std::numeric_limits<float>::max();  // of finite coordinates, most of them
constexpr double plane_margin = 1e-3;  // of the radius, so that rounding clips nothing off the sphere

bool fits(std::size_t attribute, std::size_t vertices) {
    return attribute == 0 || attribute == vertices;
}

Status check_mesh(const codec::Primitive& primitive, const std::string& where) {
    const mesh::Mesh& m = primitive.mesh;
    const std::size_t vertices = m.positions.size();
    if (m.triangles.size() > codec::max_decoded_triangles)
        return fail(ErrorCode::limit_exceeded, where + ": too many triangles to draw");
    if (!fits(m.normals.size(), vertices) || !fits(m.colors.size(), vertices) ||
        !fits(m.texture_coordinates.size(), vertices))
        return invalid_input(where + ": an attribute is not as long as the positions");
    if (primitive.shading == codec::Shading::gouraud && m.normals.empty() && !m.triangles.empty())
        return invalid_input(where + ": Gouraud shading needs normals");
    bool finite = true;  // all are looked at, which is quicker than to stop at the first
    for (const Vec3f& p : m.positions) finite &= std::abs(p.x) + std::abs(p.y) + std::abs(p.z) <= largest_sum;
    if (!finite && !std::all_of(m.positions.begin(), m.positions.end(), [](const Vec3f& p) { return all_finite(p); }))
        return invalid_input(where + ": a position is not finite");
    std::uint32_t last = 0;
    for (const mesh::Triangle& t : m.triangles) last = std::max({last, t[0], t[1], t[2]});
    if (!m.triangles.empty() && last >= vertices) return invalid_input(where + ": a triangle names a missing vertex");
    return Nothing{};
}

// Around those that `is_used` marks.
Box used_bounds(const std::vector<Vec3f>& positions, const std::vector<std::uint8_t>& is_used) {
    constexpr float infinity = std::numeric_limits<float>::infinity();
    Vec3f low(infinity), high(-infinity);
    for (std::size_t v = 0; v < is_used.size(); ++v) {
        low = glm::min(low, is_used[v] ? positions[v] : low);
        high = glm::max(high, is_used[v] ? positions[v] : high);
    }
    return {Vec3d(low), Vec3d(high)};
}

// Around the vertices that triangles use.
Box used_bounds(const mesh::Mesh& m) {
    std::vector<std::uint8_t> is_used(m.positions.size(), 0);
    for (const mesh::Triangle& t : m.triangles)
        for (const std::uint32_t v : t) is_used[v] = 1;
    return used_bounds(m.positions, is_used);
}

void add(Box& box, const Box& part) {
    box.min = glm::min(box.min, part.min);
    box.max = glm::max(box.max, part.max);
}

Box local_bounds(const codec::Decoded& content) {
    Box box;
    for (const codec::Primitive& primitive : content.primitives) add(box, used_bounds(primitive.mesh));
    return box;
}

Box local_bounds(const codec::Points& content) {
    Box box;
    for (const Vec3f& p : content.cloud.positions) box.add(Vec3d(p));
    return box;
}

template <class Content>
Box moved_bounds(const Content& content) {
    Box box = local_bounds(content);
    if (box.empty()) return box;
    box.min += content.origin;
    box.max += content.origin;
    return box;
}

template <class Content>
Placement placement_of(const Content& content) {
    const Box box = local_bounds(content);
    Placement placement;
    placement.center = box.center();
    const double radius = box.radius();
    if (radius > 0.0) placement.radius = radius;
    return placement;
}

// A product of each takes a quarter of the time of a quotient.
std::vector<Vec3f> to_scene(const std::vector<Vec3f>& positions, const Placement& placement) {
    const double scale = 1.0 / std::max(placement.radius, std::numeric_limits<double>::min());
    std::vector<Vec3f> result(positions.size());
    for (std::size_t v = 0; v < positions.size(); ++v)
        result[v] = Vec3f((Vec3d(positions[v]) - placement.center) * scale);
    return result;
}

Vec3f finite_or_zero(const Vec3f& v) {
    return all_finite(v) ? v : Vec3f{0.0f};
}
Vec2f finite_or_zero(const Vec2f& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) ? v : Vec2f{0.0f};
}

// Unit length without overflow on the way; zero stays zero.
Vec3d direction(const Vec3d& v) {
    const double largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
    return largest > 0.0 ? normalize(v / largest) : Vec3d{0.0};
}

// As drawn. Where it is too thin for single precision nobody sees it.
bool faces_against_normals(const Streams& s, const mesh::Triangle& t) {
    const Vec3f a = s.positions[t[0]];
    const Vec3f face = cross(s.positions[t[1]] - a, s.positions[t[2]] - a);
    return dot(face, s.normals[t[0]] + s.normals[t[1]] + s.normals[t[2]]) < 0.0f;
}

// Which corner of each face lights it.
struct ProvokingCorners {
    std::vector<std::uint8_t> corner;         // 0 … 2, one a face
    std::vector<std::uint32_t> first_vertex;  // of each mesh vertex: the first face that it lights, or where it follows
    std::vector<std::uint32_t> uncovered;     // mesh vertices that light no face, behind the faces
};

// A corner that lights no face yet goes first, among several the one that the fewest faces still to come could use.
ProvokingCorners choose_provoking(const mesh::Mesh& m) {
    constexpr std::uint32_t unused = ~0u;
    ProvokingCorners out;
    out.first_vertex.assign(m.positions.size(), unused);
    std::vector<std::uint32_t> uses(m.positions.size(), 0);
    for (const mesh::Triangle& t : m.triangles)
        for (const std::uint32_t v : t) ++uses[v];
    const auto price = [&](std::uint32_t v) { return out.first_vertex[v] == unused ? uses[v] : unused; };
    out.corner.reserve(m.triangles.size());
    for (std::uint32_t f = 0; f < m.triangles.size(); ++f) {
        const mesh::Triangle& t = m.triangles[f];
        const auto best =
            std::min_element(t.begin(), t.end(), [&](std::uint32_t a, std::uint32_t b) { return price(a) < price(b); });
        out.corner.push_back(static_cast<std::uint8_t>(best - t.begin()));
        if (out.first_vertex[*best] == unused) out.first_vertex[*best] = f;
        for (const std::uint32_t v : t) --uses[v];
    }
    for (const mesh::Triangle& t : m.triangles)
        for (const std::uint32_t v : t) {
            if (out.first_vertex[v] != unused) continue;
            out.first_vertex[v] = static_cast<std::uint32_t>(m.triangles.size() + out.uncovered.size());
            out.uncovered.push_back(v);
        }
    return out;
}

// The same face with `corner` last.
mesh::Triangle rotated(const mesh::Triangle& t, std::uint8_t corner) {
    return {t[(corner + 1u) % 3], t[(corner + 2u) % 3], t[corner]};
}

// How far a place lies inside the picture, by its nearest side, or plane where near and far count too; outside below 0.
double depth_inside(const Camera& camera, const Vec3d& place, int axes) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    double least = camera.sees_scene ? infinity : -infinity;
    const Mat4d rows = transpose(Mat4d(camera.clip_from_scene));
    for (int axis = 0; axis < axes; ++axis)
        for (const double side : {-1.0, 1.0}) {
            const Vec4d plane = rows[3] + side * rows[axis];
            least = std::min(least, dot(plane, Vec4d(place, 1.0)) / glm::length(Vec3d(plane)));
        }
    return least;
}

template <class T>
std::uint64_t bytes_of(const std::vector<T>& stream) {
    return stream.size() * sizeof(T);
}
std::uint64_t bytes_of(const Streams& s) {
    return bytes_of(s.positions) + bytes_of(s.normals) + bytes_of(s.first_corners) + bytes_of(s.previous_corners) +
           bytes_of(s.colors) + bytes_of(s.texture_coordinates) + bytes_of(s.indices);
}

Mat4d perspective(double tan_half_fov_y, double aspect, double near, double far) {
    Mat4d m{0.0};
    m[0][0] = 1.0 / (tan_half_fov_y * aspect);
    m[1][1] = 1.0 / tan_half_fov_y;
    m[2][2] = -(far + near) / (far - near);
    m[2][3] = -1.0;
    m[3][2] = -2.0 * far * near / (far - near);
    return m;
}

// Rows right, up, backwards; +y is up unless the eye looks along it.
Mat4d look(const Vec3d& eye, const Vec3d& forward) {
    const Vec3d world_up = std::abs(forward.y) > 1.0 - 1e-9 ? Vec3d{0, 0, -forward.y} : Vec3d{0, 1, 0};
    const Vec3d right = normalize(cross(forward, world_up));
    const Vec3d up = cross(right, forward);
    Mat4d m{1.0};
    for (int i = 0; i < 3; ++i) {
        m[i][0] = right[i];
        m[i][1] = up[i];
        m[i][2] = -forward[i];
    }
    m[3] = Vec4d(-dot(right, eye), -dot(up, eye), dot(forward, eye), 1.0);
    return m;
}

double tan_half_fov_y(const shading::View& view) {
    return std::tan(radians(std::clamp(view.fov_y_deg, shading::min_fov_deg, shading::max_fov_deg)) / 2.0);
}

}  // namespace

codec::Decoded drawable(const mesh::Model& model, const mesh::Mesh& level, std::span<const std::uint8_t> gouraud) {
    assert(gouraud.empty() || gouraud.size() == level.triangles.size());
    codec::Decoded out;
    out.materials = model.materials;
    if (out.materials.empty()) out.materials.emplace_back();
    out.images = model.images;
    out.origin = model.origin;
    std::map<std::pair<std::uint32_t, bool>, std::vector<mesh::Triangle>> parts;  // material, flat
    for (std::size_t t = 0; t < level.triangles.size(); ++t) {
        const bool flat = level.normals.empty() || (!gouraud.empty() && gouraud[t] == 0);
        parts[{mesh::material_of(level, t), flat}].push_back(level.triangles[t]);
    }
    constexpr std::uint32_t unused = ~0u;
    std::vector<std::uint32_t> renamed(level.positions.size());
    for (const auto& [key, triangles] : parts) {
        codec::Primitive primitive{key.second ? codec::Shading::flat : codec::Shading::gouraud, key.first, {}};
        mesh::Mesh& m = primitive.mesh;
        std::fill(renamed.begin(), renamed.end(), unused);
        for (mesh::Triangle t : triangles) {
            for (std::uint32_t& v : t) {
                const std::uint32_t old = v;
                if (renamed[old] == unused) {
                    renamed[old] = static_cast<std::uint32_t>(m.positions.size());
                    m.positions.push_back(level.positions[old]);
                    if (!key.second) m.normals.push_back(level.normals[old]);
                    if (!level.colors.empty()) m.colors.push_back(level.colors[old]);
                    if (!level.texture_coordinates.empty())
                        m.texture_coordinates.push_back(level.texture_coordinates[old]);
                }
                v = renamed[old];
            }
            m.triangles.push_back(t);
        }
        out.primitives.push_back(std::move(primitive));
    }
    return out;
}

Box world_bounds(const codec::Decoded& content) {
    return moved_bounds(content);
}
Box world_bounds(const codec::Points& content) {
    return moved_bounds(content);
}

Placement place(const codec::Decoded& content) {
    return placement_of(content);
}
Placement place(const codec::Points& content) {
    return placement_of(content);
}

Status check_drawable(const codec::Decoded& content) {
    if (!all_finite(content.origin)) return invalid_input("the level's origin is not finite");
    for (std::size_t i = 0; i < content.primitives.size(); ++i) {
        const std::string where = "primitive " + std::to_string(i);
        if (auto mesh = check_mesh(content.primitives[i], where); !mesh) return mesh;
        if (!content.primitives[i].mesh.triangles.empty() && content.primitives[i].material >= content.materials.size())
            return invalid_input(where + ": its material is missing");
    }
    return Nothing{};
}

Status check_drawable(const codec::Points& content) {
    const points::PointCloud& cloud = content.cloud;
    if (!all_finite(content.origin)) return invalid_input("the cloud's origin is not finite");
    if (!fits(cloud.normals.size(), cloud.positions.size()) || !fits(cloud.colors.size(), cloud.positions.size()))
        return invalid_input("an attribute of the cloud is not as long as its positions");
    if (cloud.positions.size() > points::max_points) return fail(ErrorCode::limit_exceeded, "too many points to draw");
    for (const Vec3f& p : cloud.positions)
        if (!all_finite(p)) return invalid_input("a position of the cloud is not finite");
    for (const points::Level& level : content.levels)
        if (!std::isfinite(level.radius) || level.radius < 0.0)
            return invalid_input("a level of the cloud has no finite radius");
    return Nothing{};
}

Streams gouraud_streams(const mesh::Mesh& mesh, const Placement& placement, bool textured) {
    Streams s;
    s.positions = to_scene(mesh.positions, placement);
    s.normals = mesh.normals;
    for (Vec3f& n : s.normals) n = finite_or_zero(n);
    s.colors = mesh.colors;
    if (textured)
        for (const Vec2f& uv : mesh.texture_coordinates) s.texture_coordinates.push_back(finite_or_zero(uv));
    s.indices.resize(mesh.triangles.size() * 3);
    std::vector<std::uint8_t> is_used(mesh.positions.size(), 0);
    std::uint32_t* index = s.indices.data();
    for (const mesh::Triangle& t : mesh.triangles) {
        const bool swap = faces_against_normals(s, t);
        *index++ = t[0];
        *index++ = swap ? t[2] : t[1];
        *index++ = swap ? t[1] : t[2];
        for (const std::uint32_t v : t) is_used[v] = 1;
    }
    s.bounds = used_bounds(s.positions, is_used);
    return s;
}

Streams flat_streams(const mesh::Mesh& mesh, const Placement& placement, bool textured) {
    const ProvokingCorners provoking = choose_provoking(mesh);
    const std::vector<Vec3f> places = to_scene(mesh.positions, placement);
    Streams s;
    const auto add_vertex = [&](std::uint32_t v, const Vec3f& first, const Vec3f& previous) {
        s.positions.push_back(places[v]);
        s.first_corners.push_back(first);
        s.previous_corners.push_back(previous);
        s.bounds.add(Vec3d(s.positions.back()));
        if (!mesh.colors.empty()) s.colors.push_back(mesh.colors[v]);
        if (textured && !mesh.texture_coordinates.empty())
            s.texture_coordinates.push_back(finite_or_zero(mesh.texture_coordinates[v]));
    };
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
        const mesh::Triangle t = rotated(mesh.triangles[f], provoking.corner[f]);
        add_vertex(t[2], places[t[0]], places[t[1]]);
    }
    for (const std::uint32_t v : provoking.uncovered) add_vertex(v, Vec3f{0.0f}, Vec3f{0.0f});

    std::vector<std::uint32_t> vertex_at = provoking.first_vertex;
    s.indices.reserve(mesh.triangles.size() * 3);
    for (std::uint32_t f = 0; f < mesh.triangles.size(); ++f) {
        const mesh::Triangle t = rotated(mesh.triangles[f], provoking.corner[f]);
        vertex_at[t[2]] = f;
        s.indices.insert(s.indices.end(), {vertex_at[t[0]], vertex_at[t[1]], f});
    }
    return s;
}

Streams disc_streams(const points::PointCloud& cloud, const Placement& placement) {
    Streams s;
    s.positions = to_scene(cloud.positions, placement);
    s.normals.reserve(cloud.normals.size());
    for (const Vec3f& n : cloud.normals) s.normals.emplace_back(direction(Vec3d(finite_or_zero(n))));
    s.colors = cloud.colors;
    return s;
}

bool valid_image(const mesh::TextureReference& reference, std::size_t images) {
    return reference.image >= 0 && static_cast<std::size_t>(reference.image) < images;
}

bool is_textured(const mesh::Material& material, std::size_t images) {
    return valid_image(material.base_color_texture, images) || valid_image(material.emissive_texture, images);
}

std::vector<std::string> decode_shown(const std::vector<mesh::Image>& images,
                                      const std::vector<mesh::Material>& materials, std::uint32_t widest,
                                      const std::function<void(std::size_t image, Image&& pixels)>& take) {
    std::vector<std::string> warnings;
    std::vector<bool> shown(images.size(), false);
    for (const mesh::Material& material : materials)
        for (const auto* reference : {&material.base_color_texture, &material.emissive_texture})
            if (valid_image(*reference, images.size())) shown[static_cast<std::size_t>(reference->image)] = true;
    std::uint64_t texels = 0;
    for (std::size_t i = 0; i < images.size(); ++i) {
        if (!shown[i]) continue;
        const std::string where = "image " + std::to_string(i) + " is drawn white: ";
        auto image = image::decode(images[i].bytes);
        if (!image) {
            warnings.push_back(where + image.error().message);
        } else if (std::max(image->width, image->height) > widest || texels + image->pixels() > max_texture_texels) {
            warnings.push_back(where + "larger than the driver or the limit for a level's textures allows");
        } else {
            texels += image->pixels();
            take(i, *std::move(image));
        }
    }
    return warnings;
}

Placement place(const Box& scene) {
    const double radius = scene.radius();
    return {scene.center(), radius > 0.0 ? radius : 1.0};
}

namespace {

template <class Content>
Result<std::shared_ptr<PreparedPart>> begin_part(const Content& content, const Box& scene) {
    if (scene.empty() || !std::isfinite(scene.radius())) return invalid_input("a scene needs a finite box");
    if (auto sound = check_drawable(content); !sound) return sound.error();
    auto prepared = std::make_shared<PreparedPart>();
    prepared->scene = scene;
    return prepared;
}

Placement placed_in(const Box& scene, const Vec3d& origin) {
    Placement placement = place(scene);
    placement.center -= origin;
    return placement;
}

Sphere sphere_of(const Box& box, const Placement& placement) {
    return {(box.center() - placement.center) / placement.radius, box.radius() / placement.radius};
}

}  // namespace

Result<Part> prepare(const codec::Decoded& content, const Box& scene) {
    const auto prepared = begin_part(content, scene);
    if (!prepared) return prepared.error();
    PreparedPart& whole = **prepared;
    whole.materials = content.materials;
    whole.images.resize(content.images.size());
    const Placement placement = placed_in(scene, content.origin);
    Box bounds;
    Part part;
    for (const codec::Primitive& primitive : content.primitives) {
        if (primitive.mesh.triangles.empty()) continue;
        const bool is_flat = primitive.shading == codec::Shading::flat;
        const bool textured = is_textured(content.materials[primitive.material], content.images.size());
        whole.primitives.push_back({is_flat, primitive.material, primitive.mesh.triangles.size(),
                                    is_flat ? flat_streams(primitive.mesh, placement, textured)
                                            : gouraud_streams(primitive.mesh, placement, textured)});
        const Streams& streams = whole.primitives.back().streams;
        part.triangles += primitive.mesh.triangles.size();
        part.gpu_bytes += bytes_of(streams);
        add(bounds, streams.bounds);
    }
    whole.sphere = {bounds.center(), bounds.radius()};
    auto warnings =
        decode_shown(content.images, content.materials, image::max_side, [&](std::size_t i, Image&& pixels) {
            part.gpu_bytes += pixels.rgba.size() * 4 / 3;
            whole.images[i] = std::move(pixels);
        });
    part.prepared = *prepared;
    Result<Part> result(std::move(part));
    result.warnings = std::move(warnings);
    return result;
}

Result<Part> prepare(const codec::Points& content, const Box& scene) {
    const auto prepared = begin_part(content, scene);
    if (!prepared) return prepared.error();
    PreparedPart& whole = **prepared;
    const Placement placement = placed_in(scene, content.origin);
    whole.materials.emplace_back().base_color = content.base_color;
    whole.sphere = sphere_of(local_bounds(content), placement);
    PreparedDiscs& discs = whole.discs;
    discs.points = content.cloud.positions.size();
    if (!content.levels.empty()) discs.radius = content.levels.front().radius / placement.radius;
    discs.streams = disc_streams(content.cloud, placement);
    Part part;
    part.points = discs.points;
    part.gpu_bytes = bytes_of(discs.streams);
    part.prepared = *prepared;
    return part;
}

std::vector<Sphere> spheres_of(const std::vector<Instance>& instances, const Placement& placement) {
    std::vector<Sphere> spheres;
    spheres.reserve(instances.size());
    const Vec3d farthest(farthest_offset);
    for (const Instance& instance : instances)
        spheres.push_back({clamp(instance.offset / placement.radius, -farthest, farthest), 1.0});
    return spheres;
}

Sphere around(const std::vector<Sphere>& spheres) {
    Box box;
    for (const Sphere& sphere : spheres) box.add(sphere.center);
    Sphere all{box.center(), 1.0};
    for (const Sphere& sphere : spheres)
        all.radius = std::max(all.radius, glm::length(sphere.center - all.center) + sphere.radius);
    return all;
}

std::vector<Vec4f> lights_of(const shading::View& view, const DrawOptions& options) {
    std::vector<Vec4f> lights;
    for (const Light& light : options.lights)
        lights.emplace_back(Vec3f(direction(light.direction)), static_cast<float>(light.intensity));
    if (lights.empty()) lights.emplace_back(Vec3f(direction(view.light)), 1.0f);
    return lights;
}

Camera make_camera(const shading::View& view, const Vec3d& origin, const Placement& placement, double aspect,
                   const Sphere& scene) {
    Camera camera;
    camera.forward = direction(view.target * 0.25 - view.eye * 0.25);
    const Vec3d eye = ((view.eye - origin) - placement.center) / placement.radius;
    const Vec3d to_scene = scene.center - eye;
    const double distance = std::hypot(to_scene.x, to_scene.y, to_scene.z);
    if (!(distance < max_eye_distance * scene.radius) || camera.forward == Vec3d{0.0}) return camera;
    const double depth = dot(to_scene, camera.forward), reach = scene.radius * (1.0 + plane_margin);
    const double far = depth + reach;
    if (!(far > 0.0)) return camera;
    const double near = std::max(depth - reach, far * near_share_of_far);
    camera.eye = Vec3f(eye);
    const Mat4d view_from_scene = look(eye, camera.forward);
    camera.clip_from_scene = Mat4f(perspective(tan_half_fov_y(view), aspect, near, far) * view_from_scene);
    camera.view_from_scene = Mat3f(view_from_scene);
    camera.heights_per_unit = 0.5 / tan_half_fov_y(view);
    camera.sees_scene = true;
    return camera;
}

Mat4d pixels_from_world(const shading::View& view, std::uint32_t width, std::uint32_t height) {
    const double px_per_unit = 0.5 * height / tan_half_fov_y(view);  // at depth 1
    const Mat4d axes = transpose(look(view.eye, direction(view.target * 0.25 - view.eye * 0.25)));
    const Vec4d depth = -axes[2];
    return transpose(Mat4d(px_per_unit * axes[0] + 0.5 * width * depth, 0.5 * height * depth - px_per_unit * axes[1],
                           Vec4d(0.0), depth));
}

bool may_see(const Camera& camera, const Sphere& sphere) {
    return depth_inside(camera, sphere.center, 3) >= -sphere.radius * (1.0 + plane_margin);
}

bool lies_within(const Camera& camera, const Sphere& sphere) {
    return depth_inside(camera, sphere.center, 2) >= sphere.radius * (1.0 + plane_margin);
}

double largest_px_per_unit(const Camera& camera, const Sphere& sphere, double height_px) {
    const Mat4d rows = transpose(Mat4d(camera.clip_from_scene));
    const double depth = dot(rows[3], Vec4d(sphere.center, 1.0)) - sphere.radius;
    return depth > 0.0 ? camera.heights_per_unit * height_px / depth : std::numeric_limits<double>::infinity();
}

double largest_disc_px(const Camera& camera, const Sphere& sphere, double radius, double height_px) {
    const Mat4d rows = transpose(Mat4d(camera.clip_from_scene));
    const double x_scale = glm::length(Vec3d(rows[0])), y_scale = glm::length(Vec3d(rows[1]));
    const double depth = dot(rows[3], Vec4d(sphere.center, 1.0)) - sphere.radius;  // of the nearest centre
    if (!(depth > radius)) return std::numeric_limits<double>::infinity();
    const double off_axis = std::atan(std::hypot(1.0 / x_scale, 1.0 / y_scale));  // of the picture's corners
    const double cosine = std::cos(off_axis + std::asin(radius / depth));
    return cosine > 0.0 ? radius / depth * y_scale * height_px / cosine : std::numeric_limits<double>::infinity();
}

}  // namespace lodestream::render
