// Draco behind a plain face, for the level codec and for importing KHR_draco_mesh_compression and .drc files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "common/base/result.h"
#include "common/mesh/mesh.h"

namespace lodestream::codec {

// A decoded attribute: `components` floats a point. Attributes of more than four components are not read.
struct DracoAttribute {
    enum class Semantic { position, normal, color, texture_coordinate, generic };
    Semantic semantic = Semantic::generic;
    int components = 0;         // 1 … 4
    bool normalized = false;    // integer data that stands for [0,1] or [-1,1]
    std::vector<float> values;  // components * points; integers are converted, normalized ones scaled
};

struct DracoMesh {
    std::uint32_t points = 0;
    std::vector<mesh::Triangle> triangles;               // empty for a point cloud
    std::map<std::uint32_t, DracoAttribute> attributes;  // by Draco's unique id
    // Of each point, the first one with the same value as its position; empty: no two points share one.
    std::vector<std::uint32_t> first_at_position;
};

// A decoded stream whose attributes are read to where they are wanted, without a copy between.
class DracoStream {
  public:
    // Decodes hostile bytes. Errors: invalid_input (damaged, truncated), limit_exceeded (more than max_points or
    // faces). Costs at most about what a sound stream of the same length and counts costs.
    static Result<DracoStream> decode(std::span<const std::byte> bytes, std::uint64_t max_points,
                                      std::uint64_t max_triangles);
    DracoStream(DracoStream&&) noexcept;
    ~DracoStream();

    std::uint32_t points() const;
    // As of DracoMesh.
    Result<std::vector<mesh::Triangle>> triangles() const;
    Result<std::vector<std::uint32_t>> first_at_position() const;
    // Of one to four components. Errors: invalid_input (no attribute with this id, damaged).
    Result<DracoAttribute> attribute(std::uint32_t id) const;
    // Of so many floats, or bytes that stand for [0,1], a point; all of `values`. Errors: invalid_input (no such
    // attribute, damaged). pre: components * points() values
    Status read(std::uint32_t id, int components, std::span<float> values) const;
    Status read(std::uint32_t id, int components, std::span<std::uint8_t> values) const;
    std::vector<std::uint32_t> ids() const;

  private:
    struct Impl;
    explicit DracoStream(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

// Between the first points at their positions; as they are where `first_at_position` is empty.
std::vector<mesh::Triangle> between_positions(std::vector<mesh::Triangle> triangles,
                                              const std::vector<std::uint32_t>& first_at_position);

// All of a stream; errors as DracoStream::decode.
Result<DracoMesh> decode_draco(std::span<const std::byte> bytes, std::uint64_t max_points, std::uint64_t max_triangles);

}  // namespace lodestream::codec
