// JSON beside the HTTP calls: what the programs print with --json and what a level carries in its glTF extras.
#pragma once

#include <cstdint>
#include <string>

#include "proto/messages.h"

namespace lodestream::proto {

// One object a baked input: {"asset","kind","triangles","vertices","bake_ms","peak_memory_bytes","levels","warnings"},
// and of a scene its "hierarchy".
std::string bake_record(const Asset& asset);

struct CutRecord {
    std::string asset;
    std::uint64_t triangles = 0;
    std::uint64_t vertices = 0;
    std::uint64_t bytes = 0;  // of the file written
    double cut_ms = 0.0;
    double encode_ms = 0.0;
    double rms_error = 0.0;          // model units
    double max_error = 0.0;          // model units
    double rms_error_percent = 0.0;  // of the diagonal
    std::string out;
};
std::string cut_record(const CutRecord& cut);

struct PointCutRecord {
    std::string asset;
    std::uint64_t points = 0;
    std::uint64_t bytes = 0;  // of the file written
    double cut_ms = 0.0;
    double encode_ms = 0.0;
    double rms_error = 0.0;          // model units
    double max_error = 0.0;          // model units
    double radius = 0.0;             // model units, of the discs that leave no hole
    double rms_error_percent = 0.0;  // of the diagonal
    std::string out;
};
std::string cut_record(const PointCutRecord& cut);

// {"asset","level":{…},"shading":{…}}: the figures of a plan that its content depends on, and no others, so that equal
// content stays equal bytes.
std::string content_extras(const std::string& asset, const PlanResponse& plan);

}  // namespace lodestream::proto
