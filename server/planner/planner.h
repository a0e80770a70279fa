// The capacity query: a device's request becomes a budget, a level, a split and the content that carries them.
#pragma once

#include <cstdint>
#include <memory>
#include <string_view>

#include "common/base/result.h"
#include "common/mesh/mesh.h"
#include "common/metric/surface_distance.h"
#include "proto/messages.h"
#include "server/store/store.h"

namespace lodestream::planner {

// Plans against a store. Keeps the baked models used last in memory. All calls may come from any thread.
class Planner {
  public:
    explicit Planner(store::Store& store);
    ~Planner();

    // The whole answer. The same level, split and encoding asked for again come from the store.
    // Errors: not_found (asset), unavailable (still baking), conflict (its bake failed), invalid_input.
    Result<proto::PlanResponse> plan(const proto::PlanRequest& request);

    // The level of at most `triangles` (>= 1) of a baked asset, with its measured error.
    struct Cut {
        mesh::Model model;  // the level's mesh with the asset's materials, images and origin
        metric::SurfaceError error;
        double rms_error_percent = 0.0;
        double cut_ms = 0.0;
    };
    Result<Cut> cut(std::string_view asset, std::uint64_t triangles);

    void forget(std::string_view asset_id);  // after a removal or a new bake

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace lodestream::planner
