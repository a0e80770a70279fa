// Keeps a plan beside a flight: frames tell what the device can draw, the server what of it this asset needs, and where
// the first has changed, the second is asked anew, in the background.
#pragma once

#include <cstdint>
#include <future>
#include <memory>
#include <optional>
#include <string>

#include "client/fly/pilot.h"
#include "client/sdk/client.h"
#include "common/base/result.h"
#include "common/control/budget_loop.h"
#include "proto/messages.h"

namespace lodestream::fly {

// Plans of one flight.
struct PlanSummary {
    std::uint32_t plans = 0;
    std::uint64_t first_triangles = 0, last_triangles = 0;  // the budgets
    std::string limited_by;                                 // of the last one
    double last_dlr = 0.0;                                  // Device Level Ratio, likewise
    std::uint32_t failures = 0;                             // asked in vain; the plan before goes on
    std::string last_failure;
};

class PlanFollower {
  public:
    // Asks for the first plan, by what `costs` promise, and waits for it. Display, frame rate and triangles per second
    // of the request are replaced by the screen's, the target and what was measured. Errors: those of Client::plan().
    static Result<PlanFollower> start(const std::string& server, proto::PlanRequest request,
                                      const control::FrameCosts& costs, const Screen& screen, double target_fps);

    // Triangles that the coming frame may have; control::Flight::budget.
    double budget(const std::optional<control::DrawnFrame>& before);

    // In how many steps the border between Gouraud and flat moves with the distance, by the last plan.
    std::uint32_t distance_steps() const;

    // Waits for a plan that is under way.
    PlanSummary finish();

  private:
    PlanFollower() = default;
    void set_basis(const control::PlanBasis& basis);
    void receive();
    void take(const proto::PlanResponse& plan);
    std::optional<control::PlanBasis> follow(control::DrawnFrame frame);

    std::shared_ptr<sdk::Client> client_;  // in use by `asked_` while that is valid
    proto::PlanRequest request_;
    control::FrameCosts costs_;
    Screen screen_;
    double target_fps_ = 0.0;
    control::BudgetLoopState loop_;
    std::optional<control::PlanBasis> wish_;  // waits for the plan under way
    std::future<Result<proto::PlanResponse>> asked_;
    PlanSummary summary_;
};

}  // namespace lodestream::fly
