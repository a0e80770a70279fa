// What the point-cloud paper measured ("point-cloud LOD for low-level GPUs"; seeds-digest, section 3).
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "client/report/crowd.h"

namespace lodestream::bench {

using PointLevels = std::array<std::uint64_t, report::crowd_levels>;  // points, finest first

struct PointsPaper {
    PointLevels levels;  // Table 3
    double f = 0.0;      // Table 12
    // Frames a second without and with levels, by instances: up to 289 on a Nexus 7 (Tables 8 and 9), beyond on a GTX
    // 750 (Tables 4 and 5).
    std::map<std::uint64_t, std::array<double, 2>> fps;

    std::optional<double> gain(std::uint64_t instances) const {
        const auto found = fps.find(instances);
        if (found == fps.end()) return std::nullopt;
        return found->second[1] / found->second[0];
    }
};

inline const std::map<std::string, PointsPaper> points_papers{
    {"buddha",
     {{300'000, 138'967, 89'022, 35'492, 22'301},
      0.959,
      {{25, {24, 26}},
       {81, {12, 18}},
       {121, {10, 16}},
       {169, {8, 14}},
       {225, {6, 14}},
       {289, {4, 12}},
       {441, {14, 26}},
       {961, {6, 18}},
       {1681, {4, 14}},
       {5041, {2, 8}},
       {6561, {2, 6}}}}},
    {"dragon",
     {{300'000, 109'486, 69'952, 27'251, 17'478},
      0.944,
      {{25, {24, 26}},
       {81, {12, 22}},
       {121, {10, 20}},
       {169, {8, 18}},
       {225, {6, 14}},
       {289, {4, 13}},
       {441, {14, 32}},
       {961, {6, 22}},
       {1681, {4, 18}},
       {5041, {2, 12}},
       {6561, {2, 8}}}}},
    {"bunny",
     {{14'904, 12'654, 7'092, 3'191, 800},
      0.965,
      {{25, {40, 44}},
       {81, {36, 40}},
       {121, {34, 40}},
       {169, {32, 38}},
       {225, {30, 38}},
       {289, {28, 36}},
       {441, {120, 120}},
       {961, {120, 120}},
       {1681, {74, 120}},
       {5041, {26, 120}},
       {6561, {20, 100}}}}},
    {"lucy",
     {{1'346'640, 81'566, 52'162, 39'897, 20'354},
      0.918,
      {{25, {10, 26}},
       {81, {4, 20}},
       {121, {1, 18}},
       {169, {1, 18}},
       {225, {1, 16}},
       {289, {1, 13}},
       {441, {4, 20}},
       {961, {2, 16}},
       {1681, {2, 14}},
       {5041, {2, 10}},
       {6561, {2, 8}}}}},
    {"armadillo",
     {{1'037'832, 64'200, 41'211, 31'621, 16'102},
      0.928,
      {{25, {12, 28}},
       {81, {4, 24}},
       {121, {2, 22}},
       {169, {1, 20}},
       {225, {1, 20}},
       {289, {1, 16}},
       {441, {4, 24}},
       {961, {2, 20}},
       {1681, {2, 18}},
       {5041, {2, 12}},
       {6561, {2, 10}}}}},
};

}  // namespace lodestream::bench
