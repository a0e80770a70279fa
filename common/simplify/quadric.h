// Area-weighted quadric error (Garland and Heckbert 1997), in double precision.
#pragma once

#include "common/base/math.h"

namespace lodestream::simplify {

// Sum of weight * (normal·x + offset)² over planes: x·A·x + 2 b·x + c with a symmetric A.
struct Quadric {
    double xx = 0, yy = 0, zz = 0, xy = 0, xz = 0, yz = 0;
    Vec3d b{0.0};
    double c = 0;
    double area = 0;  // of the triangles that were added, each counted in full

    // pre: `normal` is of unit length
    void add_plane(const Vec3d& normal, const Vec3d& point, double weight) {
        const double offset = -dot(normal, point);
        const Vec3d scaled = weight * normal;
        xx += scaled.x * normal.x;
        yy += scaled.y * normal.y;
        zz += scaled.z * normal.z;
        xy += scaled.x * normal.y;
        xz += scaled.x * normal.z;
        yz += scaled.y * normal.z;
        b += offset * scaled;
        c += weight * offset * offset;
    }

    Quadric& operator+=(const Quadric& other) {
        xx += other.xx;
        yy += other.yy;
        zz += other.zz;
        xy += other.xy;
        xz += other.xz;
        yz += other.yz;
        b += other.b;
        c += other.c;
        area += other.area;
        return *this;
    }

    // Never negative, though rounding can make the sum so.
    double error(const Vec3d& p) const {
        const double rx = xx * p.x + 2 * (xy * p.y + xz * p.z + b.x);
        const double ry = yy * p.y + 2 * (yz * p.z + b.y);
        const double rz = zz * p.z + 2 * b.z;
        return std::max(0.0, rx * p.x + ry * p.y + rz * p.z + c);
    }
};

}  // namespace lodestream::simplify
