// What benchmarks write (tests/bench) and the report shows: what this project and its peers make of the same levels.
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

// Where and of what it was measured.
struct RunOrigin {
    std::string command, commit, date, cpu;
    std::uint32_t cores = 0;
};

struct MethodRun {
    RunOrigin origin;
    std::vector<MethodLevel> levels;
};

// A level of a model by one codec in one setting.
struct CodecTrial {
    std::string model, codec, setting;
    bool is_default = false;  // what the codec is used with
    std::uint64_t triangles = 0, bytes = 0;
    double encode_ms = 0.0, decode_ms = 0.0;  // CPU time
    double image_rms = 0.0;                   // steps of 255, against the level before encoding
};

struct CodecRun {
    RunOrigin origin;
    std::vector<CodecTrial> trials;
};

// Errors: invalid_input, with the path of the field.
Result<MethodRun> parse_method_run(std::string_view json);
Result<CodecRun> parse_codec_run(std::string_view json);

}  // namespace lodestream::proto
