#include "client/fly/plan_follower.h"

#include <chrono>
#include <limits>
#include <utility>

namespace lodestream::fly {

Result<PlanFollower> PlanFollower::start(const std::string& server, proto::PlanRequest request,
                                         const control::FrameCosts& costs, const Screen& screen, double target_fps) {
    Result<sdk::Client> client = sdk::Client::open(server);
    if (!client) return client.error();
    PlanFollower follower;
    follower.client_ = std::make_shared<sdk::Client>(*std::move(client));
    follower.request_ = std::move(request);
    follower.costs_ = costs;
    follower.screen_ = screen;
    follower.target_fps_ = target_fps;
    control::DrawnFrame none;
    none.work.pixels = static_cast<double>(screen.width) * screen.height;
    none.frame_ms = std::numeric_limits<double>::quiet_NaN();
    follower.set_basis(*follower.follow(none));
    const Result<proto::PlanResponse> plan = follower.client_->plan(follower.request_);
    if (!plan) return plan.error();
    follower.take(*plan);
    follower.summary_.first_triangles = plan->budget.triangles;
    return follower;
}

std::optional<control::PlanBasis> PlanFollower::follow(control::DrawnFrame frame) {
    frame.width = screen_.width;
    frame.height = screen_.height;
    control::BudgetLoopStep step = control::follow(std::move(loop_), frame, costs_, 1000.0 / target_fps_);
    loop_ = std::move(step.state);
    return step.wish;
}

double PlanFollower::budget(const std::optional<control::DrawnFrame>& before) {
    if (before)
        if (const auto wish = follow(*before)) wish_ = wish;
    if (asked_.valid() && asked_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) receive();
    if (wish_ && !asked_.valid()) {
        set_basis(*std::exchange(wish_, std::nullopt));
        asked_ =
            std::async(std::launch::async, [client = client_, request = request_] { return client->plan(request); });
    }
    return static_cast<double>(summary_.last_triangles);
}

void PlanFollower::set_basis(const control::PlanBasis& basis) {
    request_.budget.device.triangles_per_second = basis.triangles_per_second;
    request_.budget.display = budget::Display{basis.width, basis.height};
    request_.budget.preference.target_fps = target_fps_;
}

void PlanFollower::receive() {
    const Result<proto::PlanResponse> plan = asked_.get();
    if (plan) return take(*plan);
    ++summary_.failures;
    summary_.last_failure = plan.error().message;
}

void PlanFollower::take(const proto::PlanResponse& plan) {
    ++summary_.plans;
    summary_.last_triangles = plan.budget.triangles;
    summary_.limited_by = plan.budget.limited_by;
    summary_.last_dlr = plan.dlr;
}

std::uint32_t PlanFollower::distance_steps() const {
    return shading::distance_steps(summary_.last_dlr);
}

PlanSummary PlanFollower::finish() {
    if (asked_.valid()) receive();
    return summary_;
}

}  // namespace lodestream::fly
