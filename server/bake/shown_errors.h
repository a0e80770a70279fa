// What an asset's levels of triangles and of points are off in pictures (common/points/pictures.h), measured in the
// bake: a plan weighs one against the other by them.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/points/level.h"
#include "common/points/order.h"
#include "common/simplify/history.h"
#include "server/bake/surface_colors.h"
#include "server/store/store.h"

namespace lodestream::bake {

struct ShownError {
    std::uint64_t count = 0;  // of triangles or points
    double error = 0.0;       // of steps from black to white, RMS
};

// Coarsest first.
struct ShownErrors {
    std::vector<ShownError> gouraud, flat;  // of the same counts: powers of two, and the whole model
    std::vector<ShownError> points;         // likewise
};

inline constexpr std::string_view shown_errors_key = "points/shown";  // among an asset's content
inline constexpr std::uint64_t max_shown_bytes = 1u << 20;
inline constexpr std::uint64_t finest_shown = 1u << 17;  // triangles or points, beside the whole model's

// Of a level of `count`, between those measured by the logarithms of both; beyond them the nearest's. 0 without any.
double error_at(std::span<const ShownError> errors, std::uint64_t count);

struct ShownSource {
    const SurfaceColors& colors;               // of `finest`
    const mesh::Mesh& finest;                  // the whole model
    simplify::HistoryView history;             // whose cuts are its levels
    const points::PointCloud& cloud;           // ordered
    const std::vector<points::Level>& levels;  // of it
};
ShownErrors measure_shown_errors(const ShownSource& source, const simplify::Executor& executor);

Status put_shown_errors(store::Store& store, const std::string& asset_id, const ShownErrors& errors);
// Errors: not_found (none were measured, as of scenes and in bakes of older servers), those of reading.
Result<ShownErrors> load_shown_errors(const store::Store& store, const std::string& asset_id);

}  // namespace lodestream::bake
