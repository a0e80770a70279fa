// A LOD level as plain glTF 2.0 binary with KHR_draco_mesh_compression, and back.
// A hybrid level: each material's Gouraud triangles form a primitive with NORMAL, its flat triangles one without, which
// glTF 2.0 (§3.7.2.1) says must be drawn with flat normals. All primitives share one quantization grid, so the vertices
// along the border decode to the same bits.
// A *lean* level is glTF too, for this project's own decoder: each material is one primitive without NORMAL, so that no
// border is coded twice, and which of its triangles are Gouraud, with the normals that cannot be derived from them,
// stands in a buffer view that the primitive's extras name (lean_shading.h). Other viewers draw all of it flat.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/base/result.h"
#include "common/mesh/mesh.h"

namespace lodestream::codec {

// One grid for everything that must fit together: an asset, a tileset.
struct QuantizationGrid {
    Vec3f origin{0.0f};
    float range = 1.0f;  // > 0, the same on all three axes
    int bits = 14;       // [min_position_bits, max_position_bits]
    double step() const { return static_cast<double>(range) / ((1u << bits) - 1u); }
};

inline constexpr int min_position_bits = 6;
inline constexpr int max_position_bits = 20;

// The step always resolves 1/16 of the mean edge, and never more than 1/64 of it: a finer one no longer tilts a
// triangle by as much as 8-bit normals do, and its bytes buy less than the same bytes of triangles would.
inline constexpr double coarsest_steps_per_edge = 16.0;
inline constexpr double finest_steps_per_edge = 64.0;

// The grid around `bounds` whose step moves a vertex by at most a quarter of `error` within the limits above. Levels of
// one asset that are given the same `bounds` differ in `bits` alone. Where neither length is positive: the most bits.
QuantizationGrid choose_grid(const Box& bounds, double error, double mean_edge_length);

// A window around `bounds` of the one lattice whose points are whole multiples of a power of two, the greatest that is
// not above choose_grid()'s step. Windows of one step decode a position that they share to the same bits, and a small
// part of a large scene needs no more bits for being far from its middle.
QuantizationGrid choose_window(const Box& bounds, double error, double mean_edge_length);

// An image to be sent in place of one of the model's.
struct SmallerImage {
    const mesh::Image* image = nullptr;     // null: the model's own
    std::uint64_t bytes_below_a_pixel = 0;  // of the bytes saved, those that the display could not have shown
};

struct EncodeOptions {
    QuantizationGrid grid;
    bool lean = false;
    int normal_bits = 8;  // plain only
    int texture_coordinate_bits = 12;
    std::vector<SmallerImage> images;  // one for each of the model's; empty: all as they are
    std::string extras_json;           // an object, put into the asset's `extras.lodestream`; empty: none
};

struct Encoded {
    std::vector<std::byte> glb;
    std::uint64_t triangles = 0;
    std::uint64_t vertices = 0;                                   // as decoded, summed over the primitives
    std::uint64_t geometry_bytes = 0;                             // of the Draco streams and the lean shading
    std::uint64_t texture_bytes = 0;                              // of the images
    std::vector<std::pair<std::string, std::uint64_t>> left_out;  // what, and the bytes that it would have cost
};

enum class Shading { gouraud, flat };

struct Primitive {
    Shading shading = Shading::gouraud;
    std::uint32_t material = 0;
    mesh::Mesh mesh;  // normals empty where flat
};

struct Decoded {
    std::vector<Primitive> primitives;
    std::vector<mesh::Material> materials;
    std::vector<mesh::Image> images;
    Vec3d origin{0.0};
    std::string extras_json;
};

// Encodes `level` with the materials and images of `model` that it uses. `gouraud[t]` != 0: triangle t is Gouraud
// shaded. Leaves out texture coordinates where no used texture reads them, colours that are constant (moved into the
// material), unused materials and images, and what smaller images lack. The result has been decoded again and compared
// with `level`: same triangles, positions within half a grid step, borders identical; lean Gouraud normals are within
// lean_normal_tolerance_degrees. Errors: invalid_input (too many
// triangles, not finite), internal.
Result<Encoded> encode_level(const mesh::Model& model, const mesh::Mesh& level, std::span<const std::uint8_t> gouraud,
                             const EncodeOptions& options);

inline constexpr std::uint64_t max_decoded_triangles = 100'000'000;
inline constexpr std::uint64_t max_decoded_vertices = 100'000'000;

// Reads what encode_level wrote. The bytes are hostile: any damage is an error, never a crash or an unbounded
// allocation.
Result<Decoded> decode_level(std::span<const std::byte> glb);

}  // namespace lodestream::codec
