#include "common/metric/surface_distance.h"

#include <algorithm>
#include <cmath>

#include "common/mesh/operations.h"
#include "common/metric/triangle_tree.h"

namespace lodestream::metric {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

// Hints carry the rounding of a square root and of float samples; a little slack keeps them upper bounds.
constexpr double hint_slack = 1.0 + 1e-9;

// The k-th number of a fixed sequence, in [0, 1): a hash (splitmix64), so any sample can be made on its own.
double random_number(std::uint64_t k) {
    k += 0x9e3779b97f4a7c15ull;
    k = (k ^ (k >> 30)) * 0xbf58476d1ce4e5b9ull;
    k = (k ^ (k >> 27)) * 0x94d049bb133111ebull;
    return static_cast<double>((k ^ (k >> 31)) >> 11) * 0x1p-53;
}

// One place in each of `count` strips of equal area, in the order of the triangles: which of them, and the weights of
// its second and third corner. `corners(i)`: those of triangle i.
template <class CornersOf, class Take>
void sample_area(std::size_t triangles, const CornersOf& corners, std::size_t count, const Take& take) {
    const auto area = [&](std::size_t i) {
        const TriangleTree::Corners t = corners(i);
        return mesh::face_area(t[0], t[1], t[2]);
    };
    double total = 0;
    for (std::size_t i = 0; i < triangles; ++i) total += area(i);
    if (!(total > 0)) return;
    const double strip = total / static_cast<double>(count);
    double covered = 0;
    std::size_t k = 0;
    for (std::size_t i = 0; i < triangles; ++i) {
        covered += area(i);
        while (k < count && (static_cast<double>(k) + random_number(3 * k)) * strip < covered) {
            const double u = random_number(3 * k + 1), v = random_number(3 * k + 2);
            if (u + v > 1)
                take(i, 1 - u, 1 - v);
            else
                take(i, u, v);
            ++k;
        }
    }
}

Vec3d blend(const Vec3f& a, const Vec3f& b, const Vec3f& c, double u, double v) {
    const Vec3d first(a);
    return first + u * (Vec3d(b) - first) + v * (Vec3d(c) - first);
}

void add_area_samples(const std::vector<TriangleTree::Corners>& triangles, std::size_t count,
                      std::vector<Vec3f>& samples) {
    sample_area(
        triangles.size(), [&](std::size_t i) { return triangles[i]; }, count,
        [&](std::size_t i, double u, double v) {
            const TriangleTree::Corners& t = triangles[i];
            samples.emplace_back(blend(t[0], t[1], t[2], u, v));
        });
}

// Every corner of the triangles once or, of more than `limit`, an even choice; in the order of the triangles.
void add_vertex_samples(const std::vector<TriangleTree::Corners>& triangles, const std::vector<Vec3f>& positions,
                        std::size_t limit, std::vector<Vec3f>& samples) {
    if (positions.size() <= limit) {
        samples.insert(samples.end(), positions.begin(), positions.end());
        return;
    }
    const std::size_t corners = 3 * triangles.size(), count = std::min(limit, corners);
    for (std::size_t k = 0; k < count; ++k) {
        const std::size_t corner = k * corners / count;
        samples.push_back(triangles[corner / 3][corner % 3]);
    }
}

std::vector<Vec3f> used_positions(const mesh::Mesh& mesh) {
    std::vector<bool> used(mesh.positions.size(), false);
    std::vector<Vec3f> positions;
    for (const mesh::Triangle& t : mesh.triangles)
        for (const std::uint32_t v : t) {
            if (used[v]) continue;
            used[v] = true;
            positions.push_back(mesh.positions[v]);
        }
    return positions;
}

}  // namespace

void NormalError::add(const Vec3d& a, const Vec3d& b) {
    const double cosine = dot(a, b);
    if (!(cosine > 0.0)) return;
    const double angle = std::atan2(length(cross(a, b)), cosine);
    squares_ += angle * angle;
    ++count_;
}

double NormalError::degrees() const {
    return count_ > 0.0 ? glm::degrees(std::sqrt(squares_ / count_)) : 0.0;
}

struct SurfaceIndex::Impl {
    Impl(const mesh::Mesh& mesh, std::size_t samples_asked) : tree(mesh), asked(samples_asked) {
        add_vertex_samples(tree.triangles(), used_positions(mesh), asked, samples);
        vertices = samples.size();
        samples.reserve(vertices + asked);
        add_area_samples(tree.triangles(), asked, samples);
    }

    TriangleTree tree;
    std::size_t asked;
    std::vector<Vec3f> samples;
    std::size_t vertices = 0;  // the first of the samples
};

SurfaceIndex::SurfaceIndex(const mesh::Mesh& mesh, std::size_t samples)
    : impl_(std::make_unique<Impl>(mesh, samples)) {}
SurfaceIndex::~SurfaceIndex() = default;
SurfaceIndex::SurfaceIndex(SurfaceIndex&&) noexcept = default;
SurfaceIndex& SurfaceIndex::operator=(SurfaceIndex&&) noexcept = default;

double SurfaceIndex::distance(const Vec3d& point, double hint) const {
    const double squared = impl_->tree.squared_distance(point, hint * hint);
    return squared < hint * hint ? std::sqrt(squared) : hint;
}

const std::vector<Vec3f>& SurfaceIndex::samples() const {
    return impl_->samples;
}

void SurfaceIndex::keep_samples(const std::function<bool(const Vec3f&)>& keep) {
    std::vector<Vec3f> kept;
    std::size_t kept_vertices = 0;
    for (std::size_t i = 0; i < impl_->samples.size(); ++i) {
        if (i == impl_->vertices) kept_vertices = kept.size();
        if (keep(impl_->samples[i])) kept.push_back(impl_->samples[i]);
    }
    impl_->vertices = impl_->vertices < impl_->samples.size() ? kept_vertices : kept.size();
    impl_->samples = std::move(kept);
}

namespace {

// From `samples` to `surface`; the first `vertices` samples count for the maximum alone, unless they are all there is.
SurfaceError one_sided(const std::vector<Vec3f>& samples, std::size_t vertices, const SurfaceIndex& surface) {
    SurfaceError error;
    const std::size_t first = vertices < samples.size() ? vertices : 0;
    std::vector<double> distances;
    distances.reserve(samples.size() - first);
    double before = infinity;
    for (std::size_t i = 0; i < samples.size(); ++i) {
        const Vec3d point(samples[i]);
        const double step = i > 0 ? length(point - Vec3d(samples[i - 1])) : 0.0;
        before = surface.distance(point, (before + step) * hint_slack);
        error.max = std::max(error.max, before);
        if (i >= first) distances.push_back(before);
    }
    if (!(error.max > 0)) return error;
    double sum = 0;
    for (const double d : distances) sum += (d / error.max) * (d / error.max);
    error.rms = error.max * std::sqrt(sum / static_cast<double>(distances.size()));
    return error;
}

double normal_error_degrees(const TriangleTree& tree, const mesh::Mesh& original, const mesh::Mesh& level,
                            std::size_t samples) {
    if (original.normals.empty() || level.normals.empty()) return 0.0;
    NormalError error;
    const auto compare = [&](std::size_t i, double u, double v) {
        const mesh::Triangle& t = level.triangles[i];
        const auto& p = level.positions;
        const auto& n = level.normals;
        const SurfacePlace place = nearest_place(tree, original, blend(p[t[0]], p[t[1]], p[t[2]], u, v));
        const auto& there = original.normals;
        const auto [a, b, c] = place.triangle;
        error.add(blend(n[t[0]], n[t[1]], n[t[2]], u, v),
                  blend(there[a], there[b], there[c], place.weights.y, place.weights.z));
    };
    const auto corners = [&](std::size_t i) {
        const mesh::Triangle& t = level.triangles[i];
        return TriangleTree::Corners{level.positions[t[0]], level.positions[t[1]], level.positions[t[2]]};
    };
    sample_area(level.triangles.size(), corners, samples, compare);
    return error.degrees();
}

}  // namespace

SurfaceError measure(const SurfaceIndex& original, const mesh::Mesh& original_mesh, const mesh::Mesh& level) {
    if (original_mesh.triangles.empty() || level.triangles.empty()) {
        const double diagonal = std::max(mesh::bounds(original_mesh).diagonal(), mesh::bounds(level).diagonal());
        return {diagonal, diagonal, 0.0};
    }
    const SurfaceIndex level_index(level, original.impl_->asked);
    const SurfaceError out = one_sided(original.impl_->samples, original.impl_->vertices, level_index);
    const SurfaceError back = one_sided(level_index.impl_->samples, level_index.impl_->vertices, original);
    return {
        std::max(out.rms, back.rms), std::max(out.max, back.max),
        normal_error_degrees(original.impl_->tree, original_mesh, level, original.impl_->asked / samples_per_normal)};
}

}  // namespace lodestream::metric
