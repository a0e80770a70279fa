#include "common/shading/normal_errors.h"

#include <array>
#include <utility>

#include "common/mesh/operations.h"
#include "common/shading/numbers.h"

namespace lodestream::shading {
namespace {

// Weights of a triangle's corners: its middle, and a place towards each corner.
constexpr std::array<std::array<double, 3>, 4> places{
    {{1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0}, {0.6, 0.2, 0.2}, {0.2, 0.6, 0.2}, {0.2, 0.2, 0.6}}};

Vec3d blended(const std::array<Vec3d, 3>& corners, const std::array<double, 3>& weights) {
    return weights[0] * corners[0] + weights[1] * corners[1] + weights[2] * corners[2];
}

Vec3d unit_face_normal(const mesh::Mesh& mesh, const mesh::Triangle& t) {
    return unit_or_zero(mesh::face_normal(mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]));
}

double squared_distance(const Vec3d& a, const Vec3d& b) {
    return glm::dot(a - b, a - b);
}

struct Errors {
    double flat = 0.0, gouraud = 0.0;
};

Errors errors_of(const mesh::Mesh& level, const mesh::Triangle& triangle, const ReferenceSurface& reference) {
    std::array<Vec3d, 3> corners, normals;
    bool has_normals = true;
    for (std::size_t i = 0; i < 3; ++i) {
        corners[i] = Vec3d(level.positions[triangle[i]]);
        normals[i] = level.normals.empty() ? Vec3d(0.0) : unit_or_zero(Vec3d(level.normals[triangle[i]]));
        has_normals = has_normals && normals[i] != Vec3d(0.0);
        if (!all_finite(level.positions[triangle[i]])) return {};
    }
    Vec3d face = unit_face_normal(level, triangle);
    if (face == Vec3d(0.0)) return {};
    if (glm::dot(face, normals[0] + normals[1] + normals[2]) < 0.0) face = -face;

    Errors sum;
    double count = 0.0;
    for (const auto& weights : places) {
        const Vec3d there = reference.normal_near(blended(corners, weights));
        if (!(glm::dot(there, face) > 0.0)) continue;
        const Vec3d blend = has_normals ? unit_or_zero(blended(normals, weights)) : face;
        sum.flat += squared_distance(there, face);
        sum.gouraud += squared_distance(there, blend);
        ++count;
    }
    return count > 0.0 ? Errors{sum.flat / count, sum.gouraud / count} : Errors{};
}

}  // namespace

ReferenceSurface::ReferenceSurface(mesh::Mesh mesh) : mesh_(std::move(mesh)), tree_(mesh_) {}

Vec3d ReferenceSurface::normal_near(const Vec3d& point) const {
    if (mesh_.triangles.empty()) return Vec3d(0.0);
    const auto [triangle, weights] = metric::nearest_place(tree_, mesh_, point);
    Vec3d normal(0.0);
    if (!mesh_.normals.empty())
        for (int i = 0; i < 3; ++i) normal += weights[i] * Vec3d(mesh_.normals[triangle[static_cast<std::size_t>(i)]]);
    normal = unit_or_zero(normal);
    return normal != Vec3d(0.0) ? normal : unit_face_normal(mesh_, triangle);
}

NormalErrors normal_errors(const mesh::Mesh& level, const ReferenceSurface& reference) {
    NormalErrors result;
    result.flat.reserve(level.triangles.size());
    result.gouraud.reserve(level.triangles.size());
    for (const mesh::Triangle& t : level.triangles) {
        const Errors errors = errors_of(level, t, reference);
        result.flat.push_back(errors.flat);
        result.gouraud.push_back(errors.gouraud);
    }
    return result;
}

}  // namespace lodestream::shading
