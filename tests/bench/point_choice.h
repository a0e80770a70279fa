// Points against triangles of the same frame time on the weak devices of the paper, from near to far, and which of the
// two a plan takes.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "proto/benchmark_runs.h"

namespace lodestream::bench {

// The paper's PDA and phone by their files. Neither tells a rate of points: the first of these is what a plan takes
// then, the others what a probe might find where triangles are dear to set up.
inline constexpr const char* choice_devices[] = {"pda", "phone"};
inline constexpr double point_rates[] = {0.5, 2.0, 8.0};  // points drawn in the time of a triangle
// Of the frame that the object gets: alone in it, or one of as many as the paper draws.
inline constexpr double frame_shares[] = {1.0, 1.0 / 16.0, 1.0 / 256.0};
inline constexpr std::size_t choice_views = 4;  // directions, whose errors are taken together

// Every asset of one object in a store that `lodestream-server bake` has filled. No network bounds the levels, so both
// take the whole frame, unless the model or what the view can show is less. `keep` is called after each asset. Throws
// std::runtime_error.
void study_choices(const std::filesystem::path& store, std::vector<proto::PointsChoice>& choices,
                   const std::function<void()>& keep);

}  // namespace lodestream::bench
