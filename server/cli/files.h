// What several commands do with files.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "common/base/result.h"
#include "common/codec/points_codec.h"
#include "common/mesh/mesh.h"

namespace lodestream::cli {

Status write_file(const std::filesystem::path& file, std::span<const std::byte> bytes);

struct Written {
    std::uint64_t triangles = 0;
    std::uint64_t vertices = 0;
    std::uint64_t bytes = 0;
    double encode_ms = 0.0;
};
// As .glb (Draco, all Gouraud; `error` sets the quantization) or .ply, by the extension of `file`.
Result<Written> write_model(const std::filesystem::path& file, const mesh::Model& model, double error,
                            const std::string& extras_json);

// As .glb or .ply, likewise.
Result<Written> write_points(const std::filesystem::path& file, const codec::Points& points);

}  // namespace lodestream::cli
