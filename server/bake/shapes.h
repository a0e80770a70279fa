// Levels of the shapes that a scene's instances show, made once however often they are shown, and the scene as one mesh
// of a bounded size made of them.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "common/base/result.h"
#include "common/mesh/mesh.h"
#include "common/metric/surface_distance.h"

namespace lodestream::bake {

inline constexpr std::uint64_t least_shape_triangles = 12;  // of a level of a shape that has as many
// Of the level of a shape that a tile above its instances is made of: the coarsest that is off by at most this share of
// the shape's diagonal, or has at most this share of its triangles.
inline constexpr double stand_in_error = 0.02;
inline constexpr double stand_in_ratio = 0.25;

struct ShapeLevel {
    mesh::Mesh mesh;
    metric::SurfaceError error;  // against the shape, in its coordinates; none of the finest
};
using ShapeLevels = std::vector<ShapeLevel>;  // of one shape: the finest first, each of about half the triangles

// Of each shape of the model. Errors: unavailable (`progress` returned false), those of recording.
Result<std::vector<ShapeLevels>> make_shape_levels(const mesh::Model& model, const std::function<bool()>& progress);

const ShapeLevel& stand_in(const ShapeLevels& levels);

// Triangles that the levels of a whole scene are cut from, where instances make it more. The objects that are no
// instances are all in it.
inline constexpr std::uint64_t max_whole_triangles = 4'000'000;

// Both: what is off from what is off already.
metric::SurfaceError sum(const metric::SurfaceError& a, const metric::SurfaceError& b);

// The model without instances, and what it is off from the one with them: the worst of the levels that stand for them.
struct WholeModel {
    mesh::Model model;
    metric::SurfaceError error;
};
// Every shape at the finest level, as long as its instances take at most `most` triangles together with the rest of the
// model; beyond, always the one whose next level is off least is coarsened. pre: `levels` are the model's
WholeModel whole_model(const mesh::Model& model, const std::vector<ShapeLevels>& levels,
                       std::uint64_t most = max_whole_triangles);

}  // namespace lodestream::bake
