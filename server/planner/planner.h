// The capacity query: a device's request becomes a budget, a level, a split and the content that carries them.
#pragma once

#include <cstdint>
#include <memory>
#include <string_view>

#include "common/base/result.h"
#include "proto/messages.h"
#include "server/bake/bake.h"
#include "server/store/store.h"

namespace lodestream::planner {

// One cut of an asset, encoded as asked.
struct CutRequest {
    std::uint64_t triangles = 0;
    double distance = 0.0;                // d in [0,1]; sets the Gouraud share where mode is hybrid
    shading::View view;                   // for the split's order; world axes
    proto::ShadingMode mode = proto::ShadingMode::hybrid;
};

// Plans against a store. Keeps the baked models used last in memory, at most max_cached_bytes. All calls may come from any thread.
class Planner {
  public:
    explicit Planner(store::Store& store);
    ~Planner();

    // The whole answer; level and content come from the store where the same plan was made before.
    // Errors: not_found (asset), unavailable (still baking), invalid_input.
    Result<proto::PlanResponse> plan(const proto::PlanRequest& request);

    // A level of at most `triangles` with its measured error, without content.
    struct Cut {
        mesh::Mesh mesh;
        metric::SurfaceError error;
        double cut_ms = 0.0;
        double measure_ms = 0.0;
    };
    Result<Cut> cut(std::string_view asset, std::uint64_t triangles);

    void forget(std::string_view asset_id);  // after a removal or a new bake

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

inline constexpr std::uint64_t max_cached_bytes = 2ull << 30;

}  // namespace lodestream::planner
