#include "common/codec/plain_normals.h"

#include <draco/compression/attributes/normal_compression_utils.h>

#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <tuple>

#include "common/codec/key_table.h"
#include "common/codec/lean_shading.h"
#include "common/mesh/operations.h"

namespace lodestream::codec {
namespace {

using NormalKey = std::array<std::uint32_t, 3>;

NormalKey key_of(const Vec3f& n) {
    return {std::bit_cast<std::uint32_t>(n.x), std::bit_cast<std::uint32_t>(n.y), std::bit_cast<std::uint32_t>(n.z)};
}

// The normals that Draco's prediction can have, which rounds towards zero. What it encodes goes to the nearest, so that
// a normal it predicts has to be given as it predicts it, or it is a step off half of the time. One that has to be told
// is given as it is wanted.
class PredictedNormals {
  public:
    explicit PredictedNormals(int bits) { box_.SetQuantizationBits(bits); }

    Vec3f operator()(const Vec3f& n) const {
        const double sum = std::abs(double{n.x}) + std::abs(double{n.y}) + std::abs(double{n.z});
        const double scale = box_.center_value() / sum;
        std::int32_t steps[3] = {static_cast<std::int32_t>(n.x * scale), static_cast<std::int32_t>(n.y * scale), 0};
        const std::int32_t rest = box_.center_value() - std::abs(steps[0]) - std::abs(steps[1]);
        steps[2] = n.z < 0.0f ? -rest : rest;
        std::int32_t s = 0, t = 0;
        box_.IntegerVectorToQuantizedOctahedralCoords(steps, &s, &t);
        Vec3f result;
        box_.QuantizedOctahedralCoordsToUnitVector(s, t, &result[0]);
        return result;
    }

  private:
    draco::OctahedronToolBox box_;
};

class Replacement {
  public:
    Replacement(const mesh::Mesh& level, const std::vector<Vec3d>& grid_points, double tolerance_degrees, int bits)
        : predicted_(bits),
          from_(level),
          grid_points_(grid_points),
          tolerance_degrees_(tolerance_degrees),
          first_(mesh::weld_positions(level.positions)),
          local_(level.positions.size(), none) {
        result_.level = level;
    }

    void add(std::span<const std::uint32_t> triangles) {
        std::vector<Vec3f> positions;
        std::vector<std::uint32_t> used;
        std::vector<mesh::Triangle> local_triangles;
        WantedShading wanted;
        wanted.gouraud.assign(triangles.size(), 1);
        KeyTable normals(std::tuple_size_v<NormalKey>);
        for (const std::uint32_t t : triangles) {
            mesh::Triangle& triangle = local_triangles.emplace_back();
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t v = from_.triangles[t][k];
                std::uint32_t& number = local_[first_[v]];
                if (number == none) {
                    number = static_cast<std::uint32_t>(positions.size());
                    positions.emplace_back(grid_points_[v]);
                    used.push_back(first_[v]);
                }
                triangle[k] = number;
                const Vec3f& normal = from_.normals[v];
                wanted.normal_of_corner.push_back(normals.find_or_add(key_of(normal).data()));
                if (normals.size() > wanted.normals.size()) wanted.normals.push_back(normal);
            }
        }
        for (const std::uint32_t v : used) local_[v] = none;
        set(triangles, sent_normals(positions, local_triangles, wanted, tolerance_degrees_, predicted_));
    }

    Replaced result() && { return std::move(result_); }

  private:
    static constexpr std::uint32_t none = 0xffffffffu;

    void set(std::span<const std::uint32_t> triangles, const SentNormals& sent) {
        KeyTable vertices(2);
        const auto first_added = static_cast<std::uint32_t>(result_.level.positions.size());
        for (std::size_t i = 0; i < triangles.size(); ++i)
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t v = from_.triangles[triangles[i]][k], normal = sent.normal_of_corner[3 * i + k];
                const std::array key{v, normal};
                const std::uint32_t vertex = first_added + vertices.find_or_add(key.data());
                if (vertex == result_.level.positions.size()) add_vertex(v, sent.normals[normal]);
                result_.level.triangles[triangles[i]][k] = vertex;
            }
    }

    void add_vertex(std::uint32_t like, const Vec3f& normal) {
        mesh::Mesh& level = result_.level;
        level.positions.push_back(from_.positions[like]);
        level.normals.push_back(normal);
        if (!from_.texture_coordinates.empty()) level.texture_coordinates.push_back(from_.texture_coordinates[like]);
        if (!from_.colors.empty()) level.colors.push_back(from_.colors[like]);
        result_.sources.push_back(like);
    }

    PredictedNormals predicted_;
    const mesh::Mesh& from_;
    const std::vector<Vec3d>& grid_points_;
    double tolerance_degrees_;
    const std::vector<std::uint32_t> first_;
    std::vector<std::uint32_t> local_;  // of first vertices, within the material at work
    Replaced result_;
};

}  // namespace

Replaced replace_normals(const mesh::Mesh& level, std::span<const std::uint8_t> gouraud,
                         const std::vector<Vec3d>& grid_points, double tolerance_degrees, int normal_bits) {
    std::map<std::uint32_t, std::vector<std::uint32_t>> by_material;
    for (std::uint32_t t = 0; t < level.triangles.size(); ++t)
        if (gouraud[t]) by_material[mesh::material_of(level, t)].push_back(t);
    Replacement replacement(level, grid_points, tolerance_degrees, normal_bits);
    for (const auto& [material, triangles] : by_material) replacement.add(triangles);
    return std::move(replacement).result();
}

}  // namespace lodestream::codec
