#include "common/shading/paper_criterion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <tuple>

#include "common/mesh/operations.h"
#include "common/shading/numbers.h"

namespace lodestream::shading {
namespace {

// What a loop over the polygons needs of the world.
struct Lamp {
    Vec3d to_light;  // unit length or zero
    Vec3d eye;       // in the mesh's coordinates
    const Phong& phong;
};

double ambient_part(const Lamp& lamp, OperationCounts& counts) {
    ++counts.ambient;
    return lamp.phong.ambient;
}

double diffuse_part(const Lamp& lamp, const Vec3d& normal, OperationCounts& counts) {
    ++counts.diffuse;
    return lamp.phong.diffuse * std::max(0.0, glm::dot(normal, lamp.to_light));
}

double specular_part(const Lamp& lamp, const Vec3d& normal, const Vec3d& to_eye, OperationCounts& counts) {
    ++counts.specular;
    const double incidence = glm::dot(normal, lamp.to_light);
    if (!(incidence > 0.0)) return 0.0;
    const double highlight = glm::dot(2.0 * incidence * normal - lamp.to_light, to_eye);
    return highlight > 0.0 ? lamp.phong.specular * std::pow(highlight, lamp.phong.shininess) : 0.0;
}

// A channel's light is its colour times the ambient and diffuse parts, and the white highlight on top.
double over_channels(const Vec3d& color, double tinted, double white) {
    double sum = 0.0;
    for (int c = 0; c < 3; ++c)
        sum += std::clamp(finite_or_zero(color[c] * finite_or_zero(tinted) + finite_or_zero(white)), 0.0, 1.0);
    return sum;
}

bool differ(const std::array<double, 3>& intensities, OperationCounts& counts) {
    ++counts.comparisons;
    const auto [low, high] = std::minmax_element(intensities.begin(), intensities.end());
    return *high - *low > barely_different;
}

bool corners_differ(const mesh::Mesh& mesh, std::size_t triangle, const Vec3d& base, const Lamp& lamp,
                    OperationCounts& counts) {
    const double ambient = ambient_part(lamp, counts);
    std::array<double, 3> intensities{};
    for (std::size_t i = 0; i < 3; ++i) {
        const std::uint32_t v = mesh.triangles[triangle][i];
        const Vec3d normal = v < mesh.normals.size() ? unit_or_zero(Vec3d(mesh.normals[v])) : Vec3d(0.0);
        const Vec3d to_eye = unit_or_zero(lamp.eye - Vec3d(mesh.positions[v]));
        const double diffuse = diffuse_part(lamp, normal, counts);
        const double specular = specular_part(lamp, normal, to_eye, counts);
        const Vec3d color = mesh.colors.empty() ? base : base * Vec3d(mesh.colors[v]) / 255.0;
        intensities[i] = over_channels(color, ambient + diffuse, specular);
    }
    return differ(intensities, counts);
}

double perimeter(const mesh::Mesh& mesh, const mesh::Triangle& t, OperationCounts& counts) {
    ++counts.sizes;
    double sum = 0.0;
    for (std::size_t i = 0; i < 3; ++i)
        sum += glm::length(Vec3d(mesh.positions[t[i]]) - Vec3d(mesh.positions[t[(i + 1) % 3]]));
    return finite_or_zero(sum);
}

Vec3d face_normal(const mesh::Mesh& mesh, const mesh::Triangle& t, OperationCounts& counts) {
    ++counts.face_normals;
    return mesh::face_normal(mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]);
}

void add_to_corner(Vec3d& sum, const Vec3d& normal, OperationCounts& counts) {
    ++counts.corner_normals;
    sum += normal;
}

}  // namespace

PaperCriterion paper_criterion(const mesh::Mesh& mesh, const std::vector<mesh::Material>& materials, const View& view,
                               const Vec3d& origin, const Phong& phong) {
    struct Merit {
        bool differs;
        double perimeter;
    };
    PaperCriterion result;
    const Lamp lamp{unit_or_zero(view.light), view.eye - origin, phong};
    std::vector<Merit> merits;
    merits.reserve(mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const bool differs =
            corners_differ(mesh, t, base_color(materials, material_of(mesh, t)), lamp, result.operations);
        merits.push_back({differs, perimeter(mesh, mesh.triangles[t], result.operations)});
        result.differing += differs ? 1 : 0;
    }
    result.order.resize(merits.size());
    std::iota(result.order.begin(), result.order.end(), 0u);
    std::stable_sort(result.order.begin(), result.order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return std::tie(merits[a].differs, merits[a].perimeter) > std::tie(merits[b].differs, merits[b].perimeter);
    });
    return result;
}

PaperNormals paper_normals(const mesh::Mesh& mesh, std::span<const std::uint8_t> gouraud) {
    PaperNormals result;
    std::vector<Vec3d> sums(mesh.positions.size(), Vec3d(0.0));
    result.faces.assign(mesh.triangles.size(), Vec3f(0.0f));
    for (std::size_t t = 0; t < std::min(gouraud.size(), mesh.triangles.size()); ++t) {
        const Vec3d normal = face_normal(mesh, mesh.triangles[t], result.operations);
        result.faces[t] = Vec3f(normal);
        if (gouraud[t] == 0) continue;
        for (const std::uint32_t v : mesh.triangles[t]) add_to_corner(sums[v], normal, result.operations);
    }
    result.vertices.reserve(sums.size());
    for (const Vec3d& sum : sums) result.vertices.emplace_back(unit_or_zero(sum));
    return result;
}

}  // namespace lodestream::shading
