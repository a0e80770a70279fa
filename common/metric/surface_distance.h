// Measured two-sided distance between two surfaces, as METRO does (Cignoni, Rocchini, Scopigno 1998): points sampled
// evenly over each surface, the exact nearest point on the other.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "common/mesh/mesh.h"

namespace lodestream::metric {

struct SurfaceError {
    double rms = 0.0;  // model units; the larger of both sides
    double max = 0.0;  // model units; the larger of both sides
    // What the second's shading normals are off those at the nearest places of the first, RMS over its area; places
    // that face apart are two sides of a thin part and do not count. 0 where either has no normals.
    double normal_degrees = 0.0;
};

// The angle between two normals, RMS over the pairs given to it. Normals that face apart do not count, nor do zeros.
class NormalError {
  public:
    void add(const Vec3d& a, const Vec3d& b);  // of any lengths
    double degrees() const;                    // 0 without pairs

  private:
    double squares_ = 0.0, count_ = 0.0;
};

inline constexpr std::size_t default_samples = 100'000;  // on each side, beside a subset of the vertices
inline constexpr std::size_t samples_per_normal = 16;    // normals are compared at one of so many

// Answers nearest-point queries on a mesh's triangles. Immutable once built; queries may run from any thread.
class SurfaceIndex {
  public:
    // Copies what it needs. `samples`: on each side of a measurement, beside as many vertices at most.
    explicit SurfaceIndex(const mesh::Mesh& mesh, std::size_t samples = default_samples);
    ~SurfaceIndex();
    SurfaceIndex(SurfaceIndex&&) noexcept;
    SurfaceIndex& operator=(SurfaceIndex&&) noexcept;

    // Distance from a finite point to the surface, model units. `hint`: an upper bound if one is known.
    // +infinity on a mesh without triangles.
    double distance(const Vec3d& point, double hint = std::numeric_limits<double>::infinity()) const;

    // The points that measure() sends out from this surface: every vertex, then area-stratified samples. Fixed seed.
    const std::vector<Vec3f>& samples() const;
    // Leaves out those that `keep` refuses, for a surface of which not all counts.
    void keep_samples(const std::function<bool(const Vec3f&)>& keep);

  private:
    friend SurfaceError measure(const SurfaceIndex& original, const mesh::Mesh& original_mesh, const mesh::Mesh& level);
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

// Two-sided error of `level` against `original`. Both empty: 0. One empty: the other's bounding-box diagonal.
SurfaceError measure(const SurfaceIndex& original, const mesh::Mesh& original_mesh, const mesh::Mesh& level);

}  // namespace lodestream::metric
