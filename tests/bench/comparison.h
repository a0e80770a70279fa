// Runs the methods on one model in turns and measures what they return.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/metric/surface_distance.h"
#include "tests/bench/inputs.h"
#include "tests/bench/judge.h"
#include "tests/bench/methods.h"

namespace lodestream::bench {

inline constexpr std::array<double, 2> level_percents{10.0, 1.0};  // of the model's triangles

struct LevelResult {
    std::uint64_t asked = 0;
    std::uint64_t triangles = 0;
    Duration reached;  // medians over the rounds; see Level
    std::optional<metric::SurfaceError> error;
    std::optional<ImageError> image;              // with smooth normals made from the level's triangles
    std::optional<ImageError> own_normals_image;  // with the normals that the method carried along
};

struct MethodResult {
    std::string method;
    int rounds = 0;
    Duration prepared;
    Duration cut;
    std::array<LevelResult, level_percents.size()> levels;
    std::optional<double> peak_bytes_per_vertex;  // recording_peak_bytes(), ours only
};

struct ModelResult {
    std::string name;
    std::uint64_t triangles = 0;
    std::uint64_t vertices = 0;
    double diagonal = 0.0;
    Repairs repairs;
    std::vector<MethodResult> methods;
};

struct ComparisonOptions {
    std::vector<Method> methods;
    int max_rounds = 5;               // a method runs so often
    double seconds_per_method = 4.0;  // but starts no further round after so long
    bool errors = true;               // surface distance
    Painter* painter = nullptr;       // null: no image errors
    std::filesystem::path
        picture_folder;  // empty: none; else the first view of all methods at each level, side by side
};

ModelResult compare_methods(Input input, const ComparisonOptions& options);

}  // namespace lodestream::bench
