// Where a merge of two positions is placed and what it costs: memoryless simplification (Lindstrom and Turk 1998, 1999)
// from sums kept at each position. All triangles around a position pass through it, so relative to the position itself
// their quadric is a matrix alone and single precision is enough.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "common/base/math.h"

namespace lodestream::simplify {

// A symmetric 3×3 matrix.
template <class Real>
struct Symmetric {
    Real xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;

    Symmetric() = default;
    template <class Other>
    explicit Symmetric(const Symmetric<Other>& o)
        : xx(static_cast<Real>(o.xx)),
          xy(static_cast<Real>(o.xy)),
          xz(static_cast<Real>(o.xz)),
          yy(static_cast<Real>(o.yy)),
          yz(static_cast<Real>(o.yz)),
          zz(static_cast<Real>(o.zz)) {}

    // weight * v vᵀ
    void add_outer(const Vec3d& v, Real weight) {
        const Vec3d w = static_cast<double>(weight) * v;
        xx += static_cast<Real>(w.x * v.x);
        xy += static_cast<Real>(w.x * v.y);
        xz += static_cast<Real>(w.x * v.z);
        yy += static_cast<Real>(w.y * v.y);
        yz += static_cast<Real>(w.y * v.z);
        zz += static_cast<Real>(w.z * v.z);
    }
    void add_diagonal(Real value) {
        xx += value;
        yy += value;
        zz += value;
    }
    Symmetric& operator+=(const Symmetric& o) {
        xx += o.xx;
        xy += o.xy;
        xz += o.xz;
        yy += o.yy;
        yz += o.yz;
        zz += o.zz;
        return *this;
    }
    Real trace() const { return xx + yy + zz; }
    Vec3d operator*(const Vec3d& v) const {
        return {xx * v.x + xy * v.y + xz * v.z, xy * v.x + yy * v.y + yz * v.z, xz * v.x + yz * v.y + zz * v.z};
    }
    Real form(const Vec3d& v) const { return dot(v, *this * v); }
};

// The sums over the triangles around a position: of the squared distance to their planes (times their area) and of
// their area vectors; and over the open borders and seams that start there, of the squared distance to their lines.
struct Form {
    Symmetric<double> matrix;
    Vec3d area{0.0};

    // `twice_area`: the cross product of two sides.
    void add_triangle(const Vec3d& twice_area) {
        const double size = length(twice_area);
        if (!(size > 0)) return;
        matrix.add_outer(twice_area, 0.5 / size);
        area += 0.5 * twice_area;
    }
    void add_line(const Vec3d& side, double weight) {
        matrix.add_diagonal(weight * dot(side, side));
        matrix.add_outer(side, -weight);
    }
};

// As it is kept at each position.
struct StoredForm {
    Symmetric<float> matrix;
    float area[3] = {0, 0, 0};
    std::uint16_t triangles = 0;  // around the position; 65,535 or more: 65,535
    std::uint16_t changes = 1;    // of the surroundings since the sums were made; at first there are none

    // Sums are made anew when this share of a position's surroundings has changed.
    static constexpr std::uint16_t changed_share = 4;
    static constexpr std::uint16_t outdated = 0xffff;

    void note_change() {
        if (changes < outdated) ++changes;
    }
    void outdate() { changes = outdated; }
    bool is_stale() const { return changes > triangles / changed_share; }
    Form form() const { return {Symmetric<double>(matrix), {area[0], area[1], area[2]}}; }
};

// Pulls towards the middle of the edge where the surface leaves the place open, of the energy's trace.
inline constexpr double middle_weight = 2e-5;
// Of keeping the volume, against the squared distances.
inline constexpr double volume_weight = 6.0;
// A minimum further from the edge's middle than this many of its lengths is not trusted.
inline constexpr double max_reach = 3.0;

// The solution of matrix * x = right, matrix positive definite.
inline Vec3d solve(const Symmetric<double>& m, const Vec3d& right) {
    const double cxx = m.yy * m.zz - m.yz * m.yz, cxy = m.xz * m.yz - m.xy * m.zz, cxz = m.xy * m.yz - m.xz * m.yy;
    const double determinant = m.xx * cxx + m.xy * cxy + m.xz * cxz;
    const double cyy = m.xx * m.zz - m.xz * m.xz, cyz = m.xy * m.xz - m.xx * m.yz, czz = m.xx * m.yy - m.xy * m.xy;
    return Vec3d{cxx * right.x + cxy * right.y + cxz * right.z, cxy * right.x + cyy * right.y + cyz * right.z,
                 cxz * right.x + cyz * right.y + czz * right.z} /
           determinant;
}

// The energy of moving both ends of an edge to one place x, all relative to the edge's start.
class EdgeEnergy {
  public:
    // `shared_area`: twice the area vector of the triangles at both ends. They count twice in the energy, so that edges
    // between large triangles wait, and once in the volume.
    EdgeEnergy(const Form& a, const Form& b, const Vec3d& shared_area, const Vec3d& edge)
        : edge_(edge), length2_(dot(edge, edge)), area_(a.area - 0.5 * shared_area + b.area), matrix_(a.matrix) {
        at_end_ = std::max(0.0, matrix_.form(edge));
        matrix_ += b.matrix;
        right_ = b.matrix * edge;
        at_start_ = std::max(0.0, dot(edge, right_));
        volume_ = dot(b.area, edge);
    }

    const Vec3d& edge() const { return edge_; }
    double length2() const { return length2_; }
    double at_start() const { return at_start_; }
    double at_end() const { return at_end_; }
    double at(const Vec3d& x) const { return std::max(0.0, matrix_.form(x) - 2 * dot(x, right_) + at_start_); }
    // The place of least energy; finite always, an end where nothing else is.
    Vec3d minimum() const;

  private:
    Vec3d edge_;
    double length2_;
    Vec3d area_;                // of the triangles around both
    double volume_;             // area · x at which the volume under the triangles is kept (three times it)
    Symmetric<double> matrix_;  // energy: x·matrix·x - 2 right·x + at_start
    Vec3d right_;
    double at_start_, at_end_;
};

inline Vec3d EdgeEnergy::minimum() const {
    const Vec3d end = at_start_ <= at_end_ ? Vec3d{0.0} : edge_;
    const double trace = matrix_.trace();
    if (!(trace > 0) || !(length2_ > 0)) return end;
    Symmetric<double> m = matrix_;
    const double middle = middle_weight * trace, keep = volume_weight / trace;
    m.add_diagonal(middle);
    m.add_outer(area_, keep);
    const Vec3d x = solve(m, right_ + 0.5 * middle * edge_ + keep * volume_ * area_);
    const Vec3d off = x - 0.5 * edge_;
    return dot(off, off) <= max_reach * max_reach * length2_ ? x : end;
}

}  // namespace lodestream::simplify
