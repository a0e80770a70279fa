#include "common/scene/placement.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace lodestream::scene {

namespace {

Vec3d transformed(const Mat4d& matrix, const Vec3d& place) {
    return Vec3d(matrix * Vec4d(place, 1.0));
}

std::array<Vec3d, 8> corners(const Box& box) {
    std::array<Vec3d, 8> all;
    for (unsigned i = 0; i < 8; ++i)
        all[i] = {i & 1u ? box.max.x : box.min.x, i & 2u ? box.max.y : box.min.y, i & 4u ? box.max.z : box.min.z};
    return all;
}

// Of a placed box: the longest of its diagonals.
double extent(const Box& box, const Placement& placement) {
    if (!placement.visible) return 0.0;
    const std::array<Vec3d, 8> all = corners(box);
    double longest = 0.0;
    for (std::size_t i = 0; i < 4; ++i)
        longest = std::max(longest,
                           distance(transformed(placement.matrix, all[i]), transformed(placement.matrix, all[7 - i])));
    return longest;
}

}  // namespace

Status validate(const Placement& placement) {
    const Mat4d& m = placement.matrix;
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row)
            if (!std::isfinite(m[column][row])) return invalid_input("is not finite");
    if (m[0][3] != 0.0 || m[1][3] != 0.0 || m[2][3] != 0.0 || m[3][3] != 1.0)
        return invalid_input("is not affine: its last row must be 0, 0, 0, 1");
    const Vec3d moved(m[3]);
    if (!(std::max({std::abs(moved.x), std::abs(moved.y), std::abs(moved.z)}) <= max_coordinate))
        return invalid_input("moves farther than 1e12");
    if (!(largest_scale(m) <= max_scale)) return invalid_input("scales by more than 1e6");
    if (determinant(Mat3d(m)) == 0.0 || !(largest_scale(inverse(m)) <= max_scale))
        return invalid_input("is singular, or scales by less than 1e-6");
    return Nothing{};
}

Placement combined(const Placement& outer, const Placement& inner) {
    return {outer.matrix * inner.matrix, outer.visible && inner.visible};
}

Box placed(const Box& box, const Mat4d& matrix) {
    Box out;
    if (box.empty()) return out;
    for (const Vec3d& corner : corners(box)) out.add(transformed(matrix, corner));
    return out;
}

// The root of the greatest eigenvalue of the symmetric matrix AᵀA, in closed form.
double largest_scale(const Mat4d& matrix) {
    const Mat3d a(matrix), s = transpose(a) * a;
    const double mean = (s[0][0] + s[1][1] + s[2][2]) / 3.0;
    const Mat3d centred = s - mean * Mat3d(1.0);
    double squares = 0.0;
    for (int i = 0; i < 3; ++i) squares += dot(centred[i], centred[i]);
    const double spread = std::sqrt(squares / 6.0);
    if (!(spread > 1e-15 * mean)) return std::sqrt(mean);
    const double half = std::clamp(determinant(centred / spread) / 2.0, -1.0, 1.0);
    return std::sqrt(mean + 2.0 * spread * std::cos(std::acos(half) / 3.0));
}

double displacement(const Box& box, const Placement& shown, const Placement& is) {
    if (box.empty()) return 0.0;
    const double size = std::max(extent(box, shown), extent(box, is));
    if (shown.visible != is.visible) return size;
    double moved = 0.0;
    for (const Vec3d& corner : corners(box))
        moved = std::max(moved, distance(transformed(shown.matrix, corner), transformed(is.matrix, corner)));
    return std::min(moved, size);
}

}  // namespace lodestream::scene
