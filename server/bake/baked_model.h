// What a bake leaves in the store: everything that cutting any level needs, in a form that is used from the file
// itself.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/result.h"
#include "common/mesh/mesh.h"
#include "common/metric/surface_distance.h"
#include "common/simplify/history.h"
#include "common/texture/use.h"

namespace lodestream::bake {

// The measured error of one level.
struct ErrorSample {
    std::uint64_t triangles = 0;
    metric::SurfaceError error;
};

template <class AnyHistory>
struct BasicBakedModel {
    mesh::Model model;                          // without its mesh, which is the history's finest level
    Box bounds;                                 // of the finest level
    Box grid_bounds;                            // of all levels
    std::vector<texture::ImageUse> image_uses;  // of each of the model's images
    std::vector<double> texel_sizes;            // of each of the model's images
    std::vector<ErrorSample> errors;            // finest first: triangles fall, errors do not
    AnyHistory history;
};
using BakedModel = BasicBakedModel<simplify::History>;
using BakedView = BasicBakedModel<simplify::HistoryView>;  // its history is in the bytes that it was opened from

// All but history and errors: the mesh may be given away after this.
BakedModel describe_model(const mesh::Model& model);
// pre: `history` was recorded for the mesh of the model described.
void set_history(BakedModel& baked, simplify::History history);

// The samples finest first, with errors that do not fall where triangles do: a coarser level is never said to be
// better.
std::vector<ErrorSample> in_order(std::vector<ErrorSample> samples);
Status validate_errors(const std::vector<ErrorSample>& errors);  // of stored ones: there are some, finite, in order

std::vector<std::byte> serialize(const BakedModel& baked);
// Hostile bytes: every count and index is checked. `bytes` must begin at a multiple of 8 in memory and outlive the
// view.
Result<BakedView> open_baked_model(std::span<const std::byte> bytes);

// The error of the level of this many triangles: that of the nearest measured level that is not finer. An error may
// jump anywhere between two measured levels (spikes on a plane, pieces of two sizes), so nothing between them is
// promised, but for the normals' error: it promises nothing, and is between those of the levels around.
// pre: errors is not empty
metric::SurfaceError error_of(std::span<const ErrorSample> errors, std::uint64_t triangles);

}  // namespace lodestream::bake
