// What the simplification benchmark writes (tests/bench) and the report shows: levels that several methods made.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"

namespace lodestream::proto {

// A level that one method of simplification made of a model.
struct MethodLevel {
    std::string model, method;
    std::uint64_t model_triangles = 0;
    std::uint64_t asked = 0, triangles = 0;
    double wall_ms = 0.0, cpu_ms = 0.0;
    std::optional<double> rms_error_percent, max_error_percent;  // of the model's diagonal
    std::optional<double> image_rms;  // steps of 255; with the method's normals if it has any
};

struct MethodRun {
    std::string command, commit, date, cpu;
    std::uint32_t cores = 0;
    std::vector<MethodLevel> levels;
};

// Errors: invalid_input, with the path of the field.
Result<MethodRun> parse_method_run(std::string_view json);

}  // namespace lodestream::proto
