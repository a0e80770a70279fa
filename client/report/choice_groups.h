// Cases of points against triangles (proto::PointsChoice) put together by what the device has for the model.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "proto/benchmark_runs.h"

namespace lodestream::report {

struct ChoiceGroup {
    std::string device;
    double points_per_triangle = 0.0, frame_share = 0.0;
    std::uint64_t cases = 0;
    std::uint64_t points_nearer = 0;  // the picture of points errs less
    std::uint64_t points_taken = 0;   // by the plan
    std::uint64_t points_found = 0;   // both
    std::uint64_t right = 0;          // what the plan takes errs no more than the other
};

bool took_nearer(const proto::PointsChoice& choice);
bool points_are_nearer(const proto::PointsChoice& choice);

// In the order in which the cases first name them.
std::vector<ChoiceGroup> choice_groups(const std::vector<proto::PointsChoice>& choices);
ChoiceGroup sum_of(const std::vector<ChoiceGroup>& groups);

}  // namespace lodestream::report
