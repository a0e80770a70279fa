#include "common/mesh/operations.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <numeric>
#include <utility>

namespace lodestream::mesh {

namespace {

constexpr std::uint32_t none = 0xffffffffu;

// Above this many triangles around one position, comparing each with each is too dear; see crease_normals().
constexpr std::size_t max_compared_valence = 64;

// An open-addressing table of indices: finds the first item equal to a new one.
class IndexTable {
  public:
    explicit IndexTable(std::size_t items) : slots_(std::bit_ceil(items * 2 + 16), none), mask_(slots_.size() - 1) {}

    // The index already held that equals `index`, or `index` itself after storing it.
    template <class Equal>
    std::uint32_t find_or_add(std::uint64_t hash, std::uint32_t index, Equal equal) {
        for (std::size_t slot = hash & mask_;; slot = (slot + 1) & mask_) {
            if (slots_[slot] == none) return slots_[slot] = index;
            if (equal(slots_[slot])) return slots_[slot];
        }
    }

  private:
    std::vector<std::uint32_t> slots_;
    std::size_t mask_;
};

std::uint64_t mix(std::uint64_t h) {
    h ^= h >> 32;
    h *= 0xd6e8feb86659fd93ull;
    h ^= h >> 32;
    h *= 0xd6e8feb86659fd93ull;
    return h ^ (h >> 32);
}

std::uint64_t combine(std::uint64_t hash, float value) {
    return mix(hash ^ std::bit_cast<std::uint32_t>(value == 0.0f ? 0.0f : value));
}

std::uint64_t hash_of(const Vec3f& v, std::uint64_t seed) {
    return combine(combine(combine(seed, v.x), v.y), v.z);
}

// A vertex of `mesh` as used by a triangle of `material`.
struct Corner {
    std::uint32_t vertex;
    std::uint32_t material;
};

std::uint64_t hash_of(const Mesh& mesh, const Corner& c) {
    std::uint64_t h = hash_of(mesh.positions[c.vertex], mix(c.material + 1ull));
    if (!mesh.normals.empty()) h = hash_of(mesh.normals[c.vertex], h);
    if (!mesh.texture_coordinates.empty()) {
        const Vec2f uv = mesh.texture_coordinates[c.vertex];
        h = combine(combine(h, uv.x), uv.y);
    }
    if (!mesh.colors.empty()) h = mix(h ^ std::bit_cast<std::uint32_t>(mesh.colors[c.vertex]));
    return h;
}

bool same(const Mesh& mesh, const Corner& a, const Corner& b) {
    return a.material == b.material && mesh.positions[a.vertex] == mesh.positions[b.vertex] &&
           (mesh.normals.empty() || mesh.normals[a.vertex] == mesh.normals[b.vertex]) &&
           (mesh.texture_coordinates.empty() ||
            mesh.texture_coordinates[a.vertex] == mesh.texture_coordinates[b.vertex]) &&
           (mesh.colors.empty() || mesh.colors[a.vertex] == mesh.colors[b.vertex]);
}

bool degenerate(const Mesh& mesh, const Triangle& t) {
    const Vec3f &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
    return a == b || b == c || c == a;
}

void append_vertex(Mesh& to, const Mesh& from, std::uint32_t vertex) {
    to.positions.push_back(from.positions[vertex] + Vec3f{0.0f});  // -0 becomes +0
    if (!from.normals.empty()) to.normals.push_back(from.normals[vertex]);
    if (!from.texture_coordinates.empty()) to.texture_coordinates.push_back(from.texture_coordinates[vertex]);
    if (!from.colors.empty()) to.colors.push_back(from.colors[vertex]);
}

// The scaled cross product: its direction is the normal, its length twice the area over `scale` squared.
struct ScaledCross {
    Vec3d cross{0.0};
    double scale = 0.0;
};

ScaledCross scaled_cross(const Vec3f& a, const Vec3f& b, const Vec3f& c) {
    const Vec3d u = Vec3d(b) - Vec3d(a), v = Vec3d(c) - Vec3d(a);
    const double scale =
        std::max({std::abs(u.x), std::abs(u.y), std::abs(u.z), std::abs(v.x), std::abs(v.y), std::abs(v.z)});
    if (!(scale > 0.0) || !std::isfinite(scale)) return {};
    return {cross(u / scale, v / scale), scale};
}

double corner_angle(const Vec3f& at, const Vec3f& left, const Vec3f& right) {
    const ScaledCross sine = scaled_cross(at, left, right);
    if (sine.scale == 0.0) return 0.0;
    const Vec3d u = (Vec3d(left) - Vec3d(at)) / sine.scale, v = (Vec3d(right) - Vec3d(at)) / sine.scale;
    return std::atan2(length(sine.cross), dot(u, v));
}

// Triangle corners grouped by position: corners[first[p] … first[p + 1]) are 3 * triangle + k.
struct CornersByPosition {
    std::vector<std::uint32_t> first;
    std::vector<std::uint32_t> corners;
};

CornersByPosition corners_by_position(const Mesh& mesh) {
    const std::vector<std::uint32_t> position = weld_positions(mesh.positions);
    CornersByPosition by;
    by.first.assign(mesh.positions.size() + 1, 0);
    for (const Triangle& t : mesh.triangles)
        for (std::uint32_t v : t) ++by.first[position[v] + 1];
    std::partial_sum(by.first.begin(), by.first.end(), by.first.begin());
    by.corners.resize(3 * mesh.triangles.size());
    std::vector<std::uint32_t> next = by.first;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
        for (std::uint32_t k = 0; k < 3; ++k) by.corners[next[position[mesh.triangles[t][k]]]++] = 3 * t + k;
    return by;
}

Vec3f unit_or(const Vec3d& v, const Vec3f& otherwise) {
    const double size = length(v);
    return size > 1e-12 ? Vec3f(v / size) : otherwise;
}

// Normals of the corners around one position, written to corner_normals.
void crease_normals(const std::uint32_t* begin, const std::uint32_t* end, const std::vector<Vec3d>& face_normals,
                    const std::vector<double>& angles, double cos_crease, std::vector<Vec3f>& corner_normals) {
    Vec3d everything{0.0};
    for (const std::uint32_t* c = begin; c != end; ++c) everything += angles[*c] * face_normals[*c / 3];
    const Vec3f average = unit_or(everything, {0.0f, 1.0f, 0.0f});
    const bool compare_all = static_cast<std::size_t>(end - begin) <= max_compared_valence;

    for (const std::uint32_t* c = begin; c != end; ++c) {
        const Vec3d own = face_normals[*c / 3];
        if (own == Vec3d{0.0}) {
            corner_normals[*c] = average;
        } else if (!compare_all) {
            corner_normals[*c] = dot(own, Vec3d(average)) >= cos_crease ? average : Vec3f(own);
        } else {
            Vec3d sum{0.0};
            for (const std::uint32_t* o = begin; o != end; ++o)
                if (dot(own, face_normals[*o / 3]) >= cos_crease) sum += angles[*o] * face_normals[*o / 3];
            corner_normals[*c] = unit_or(sum, Vec3f(own));
        }
    }
}

}  // namespace

const char* kind_name(Kind kind) {
    switch (kind) {
        case Kind::mesh:
            return "mesh";
        case Kind::scene:
            return "scene";
        case Kind::terrain:
            return "terrain";
        case Kind::points:
            return "points";
    }
    return "mesh";
}

SceneGraph flat_graph(std::uint32_t objects) {
    SceneGraph graph;
    graph.parents.assign(objects + std::size_t{1}, 0);
    graph.parents.front() = no_parent;
    graph.object_nodes.resize(objects);
    std::iota(graph.object_nodes.begin(), graph.object_nodes.end(), 1u);
    return graph;
}

Box bounds(const Mesh& mesh) {
    Box box;
    for (const Triangle& t : mesh.triangles)
        for (std::uint32_t v : t) box.add(Vec3d(mesh.positions[v]));
    return box;
}

std::vector<std::uint32_t> weld_positions(const std::vector<Vec3f>& positions) {
    IndexTable table(positions.size());
    std::vector<std::uint32_t> first(positions.size());
    for (std::uint32_t i = 0; i < positions.size(); ++i)
        first[i] = table.find_or_add(hash_of(positions[i], 1), i,
                                     [&](std::uint32_t j) { return positions[i] == positions[j]; });
    return first;
}

Mesh compact(const Mesh& mesh) {
    Mesh out;
    const std::size_t corners = 3 * mesh.triangles.size();
    std::uint64_t materials = 1;
    for (const std::uint32_t m : mesh.triangle_materials) materials = std::max<std::uint64_t>(materials, m + 1ull);
    // A vertex is kept once for each material that uses it.
    IndexTable table(std::min<std::uint64_t>(corners, mesh.positions.size() * materials));
    std::vector<Corner> kept;
    kept.reserve(mesh.positions.size());
    out.triangles.reserve(mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        if (degenerate(mesh, mesh.triangles[t])) continue;
        Triangle triangle;
        for (std::size_t k = 0; k < 3; ++k) {
            const Corner corner{mesh.triangles[t][k], material_of(mesh, t)};
            const auto candidate = static_cast<std::uint32_t>(kept.size());
            triangle[k] = table.find_or_add(hash_of(mesh, corner), candidate,
                                            [&](std::uint32_t other) { return same(mesh, kept[other], corner); });
            if (triangle[k] == candidate) {
                kept.push_back(corner);
                append_vertex(out, mesh, corner.vertex);
            }
        }
        out.triangles.push_back(triangle);
        if (!mesh.triangle_materials.empty()) out.triangle_materials.push_back(mesh.triangle_materials[t]);
        if (!mesh.triangle_objects.empty()) out.triangle_objects.push_back(mesh.triangle_objects[t]);
    }
    return out;
}

Mesh part(const Mesh& mesh, std::span<const std::uint32_t> triangles) {
    Mesh out;
    std::vector<std::uint32_t> used;
    used.reserve(3 * triangles.size());
    for (const std::uint32_t t : triangles) used.insert(used.end(), mesh.triangles[t].begin(), mesh.triangles[t].end());
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    for (const std::uint32_t v : used) append_vertex(out, mesh, v);
    const auto place = [&](std::uint32_t v) {
        return static_cast<std::uint32_t>(std::lower_bound(used.begin(), used.end(), v) - used.begin());
    };
    for (const std::uint32_t t : triangles) {
        const auto [a, b, c] = mesh.triangles[t];
        out.triangles.push_back({place(a), place(b), place(c)});
        if (!mesh.triangle_materials.empty()) out.triangle_materials.push_back(mesh.triangle_materials[t]);
        if (!mesh.triangle_objects.empty()) out.triangle_objects.push_back(mesh.triangle_objects[t]);
    }
    return out;
}

Mesh placed(Mesh mesh, const Vec3d& origin, const Mat4d& matrix) {
    const Mat3d linear(matrix);
    const double det = determinant(linear);
    const Mat3d of_normals = transpose(inverse(linear)) * (det < 0.0 ? -1.0 : 1.0);
    const Vec3d offset = Vec3d(matrix * Vec4d(origin, 1.0)) - origin;
    for (Vec3f& position : mesh.positions) position = Vec3f(linear * Vec3d(position) + offset);
    for (Vec3f& normal : mesh.normals) {
        const Vec3d turned = of_normals * Vec3d(normal);
        const double size = length(turned);
        if (size > 0.0 && std::isfinite(size)) normal = Vec3f(turned / size);
    }
    if (det < 0.0)
        for (Triangle& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
    return mesh;
}

std::vector<std::uint32_t> distinct_triangles(const Mesh& mesh) {
    const std::vector<std::uint32_t> position = weld_positions(mesh.positions);
    const auto corners = [&](std::uint32_t t) {
        Triangle at;
        for (std::size_t k = 0; k < 3; ++k) at[k] = position[mesh.triangles[t][k]];
        std::rotate(at.begin(), std::min_element(at.begin(), at.end()), at.end());
        return at;
    };
    IndexTable table(mesh.triangles.size());
    std::vector<std::uint32_t> distinct;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const Triangle at = corners(t);
        const std::uint64_t hash = mix(mix(mix(at[0] + 1ull) ^ at[1]) ^ at[2]);
        if (table.find_or_add(hash, t, [&](std::uint32_t other) { return corners(other) == at; }) == t)
            distinct.push_back(t);
    }
    return distinct;
}

void append(Mesh& to, const Mesh& from) {
    const auto first = static_cast<std::uint32_t>(to.positions.size());
    const auto join = [](auto& all, const auto& more) { all.insert(all.end(), more.begin(), more.end()); };
    join(to.positions, from.positions);
    join(to.normals, from.normals);
    join(to.texture_coordinates, from.texture_coordinates);
    join(to.colors, from.colors);
    join(to.triangle_materials, from.triangle_materials);
    join(to.triangle_objects, from.triangle_objects);
    for (const auto& [a, b, c] : from.triangles) to.triangles.push_back({first + a, first + b, first + c});
}

namespace {

// The mesh with one normal for each corner of a triangle.
Mesh with_corner_normals(const Mesh& mesh, std::vector<Vec3f> normals) {
    Mesh soup;
    soup.triangle_materials = mesh.triangle_materials;
    soup.triangle_objects = mesh.triangle_objects;
    soup.triangles.reserve(mesh.triangles.size());
    Mesh bare = mesh;
    bare.normals.clear();
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        for (std::uint32_t k = 0; k < 3; ++k) append_vertex(soup, bare, mesh.triangles[t][k]);
        soup.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
    }
    soup.normals = std::move(normals);
    return compact(soup);
}

std::vector<Vec3d> face_normals_of(const Mesh& mesh) {
    std::vector<Vec3d> normals;
    normals.reserve(mesh.triangles.size());
    for (const auto& [a, b, c] : mesh.triangles)
        normals.push_back(face_normal(mesh.positions[a], mesh.positions[b], mesh.positions[c]));
    return normals;
}

std::vector<Vec3f> made_normals(const Mesh& mesh, const std::vector<Vec3d>& face_normals, double crease_degrees) {
    const std::size_t corners = 3 * mesh.triangles.size();
    std::vector<double> angles(corners);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const Triangle& triangle = mesh.triangles[t];
        const Vec3f p[3] = {mesh.positions[triangle[0]], mesh.positions[triangle[1]], mesh.positions[triangle[2]]};
        for (std::size_t k = 0; k < 3; ++k) angles[3 * t + k] = corner_angle(p[k], p[(k + 1) % 3], p[(k + 2) % 3]);
    }

    const CornersByPosition by = corners_by_position(mesh);
    const double cos_crease = std::cos(radians(crease_degrees));
    std::vector<Vec3f> normals(corners);
    for (std::size_t p = 0; p + 1 < by.first.size(); ++p)
        crease_normals(by.corners.data() + by.first[p], by.corners.data() + by.first[p + 1], face_normals, angles,
                       cos_crease, normals);
    return normals;
}

}  // namespace

Mesh with_normals(const Mesh& mesh, double crease_degrees) {
    return with_corner_normals(mesh, made_normals(mesh, face_normals_of(mesh), crease_degrees));
}

Mesh with_plausible_normals(const Mesh& mesh, double max_degrees, double crease_degrees) {
    const std::vector<Vec3d> face_normals = face_normals_of(mesh);
    const double least_cosine = std::cos(radians(max_degrees));
    std::vector<Vec3f> normals = made_normals(mesh, face_normals, crease_degrees);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3f& own = mesh.normals[mesh.triangles[t][k]];
            if (dot(Vec3d(own), face_normals[t]) >= least_cosine) normals[3 * t + k] = own;
        }
    return with_corner_normals(mesh, std::move(normals));
}

Vec3d face_normal(const Vec3f& a, const Vec3f& b, const Vec3f& c) {
    const ScaledCross s = scaled_cross(a, b, c);
    const double size = length(s.cross);
    return size > 1e-15 ? s.cross / size : Vec3d{0.0};
}

double face_area(const Vec3f& a, const Vec3f& b, const Vec3f& c) {
    const ScaledCross s = scaled_cross(a, b, c);
    return 0.5 * length(s.cross) * s.scale * s.scale;
}

double mean_edge_length(const Mesh& mesh) {
    double sum = 0.0;
    for (const Triangle& t : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k)
            sum += distance(Vec3d(mesh.positions[t[k]]), Vec3d(mesh.positions[t[(k + 1) % 3]]));
    return mesh.triangles.empty() ? 0.0 : sum / (3.0 * static_cast<double>(mesh.triangles.size()));
}

}  // namespace lodestream::mesh
