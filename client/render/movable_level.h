// A level whose border between Gouraud and flat can be moved without a download, an upload or a sort: the client puts
// the triangles into one order of importance (common/shading/importance.h, seen from anywhere), and every split is a
// prefix of it.
//
// Corners that came flat have no normals. Where a Gouraud triangle's corner lies at the same position, its normal is
// taken over (the one nearest to the face, where several are within the crease), so that shading goes on across the
// border; elsewhere they are averaged over the faces around within the crease. That is what an importer does with a
// file without normals, so a split loses the designer's own normals inside flat regions and nothing else.
//
// The order is cut into order_buckets of equal size; inside each, triangles are arranged for the GPU's vertex cache.
// The border may still stand anywhere, and at every bucket's end the choice is the exact one. More buckets keep closer
// to the order, fewer keep neighbours together: of 8,000 and 99,000 triangles of two scans a cache of 16 vertices
// transforms 0.7 vertices a triangle in one bucket, 1.3 to 1.6 in 4, 1.8 to 2.1 in 8 and 2.8 in 64; a decoded level
// has 1.1.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/result.h"
#include "common/codec/level_codec.h"
#include "common/shading/phong.h"

namespace lodestream::render {

inline constexpr double crease_degrees = 60.0;
inline constexpr std::size_t order_buckets = 8;

struct MovableLevel {
    codec::Decoded content;  // one Gouraud primitive a material, triangles by falling importance
    std::vector<std::vector<std::uint32_t>> places;  // of each primitive's triangles in the level's order, rising
    std::vector<double> difference_left;             // as importance.h's, of the level's order; size n + 1
    double radius = 0.0;                             // of the bounding sphere, model units

    std::uint64_t triangles() const { return difference_left.empty() ? 0 : difference_left.size() - 1; }
};

// Triangles of fewer than three positions are left out. Errors: invalid_input, as Renderer::upload.
Result<MovableLevel> movable_level(const codec::Decoded& content, const shading::Phong& phong = {});

}  // namespace lodestream::render
