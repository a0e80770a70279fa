// A LOD level as plain glTF 2.0 binary with KHR_draco_mesh_compression, and back.
// A hybrid level: each material's Gouraud triangles form a primitive with NORMAL, its flat triangles one without, which
// glTF 2.0 (§3.7.2.1) says must be drawn with flat normals. All primitives share one quantization grid, so the vertices
// along the border decode to the same bits.
// A *lean* level is a valid GLB too, but for this project's own decoder: each material is one primitive without NORMAL,
// so that no border is coded twice. Its geometry is a stream of its own (lean_mesh.h) in a buffer view that the
// required extension LODESTREAM_lean_mesh names; which of its triangles are Gouraud, with the normals that cannot be
// derived from them, stands in a buffer view that the primitive's extras name (lean_shading.h). Lean levels of before,
// whose geometry is a Draco stream, are read as well.
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

// How far rounding may move a level off its surface, RMS: this share of the error that the level has anyway, which
// raises a picture's error by a few percent, and of its extent about what Draco's usual 14 bits cost.
inline constexpr double off_surface_share_of_error = 0.35;
inline constexpr double off_surface_share_of_extent = 0.24 / (1 << 14);
// Lean levels are a little closer.
inline constexpr double lean_off_surface_share_of_error = 0.33;
inline constexpr double lean_off_surface_share_of_extent = 0.22 / (1 << 14);
// So are levels that show nothing but what rounding does: whose normals are off by less than this. Not where more than
// so many of the normals have to be told, being so far from what the triangles tell, which takes the bytes.
inline constexpr double faithful_normal_error_degrees = 1.0, told_normal_degrees = 0.7, most_told_normals = 0.6;
inline constexpr double faithful_off_surface_share_of_extent = 0.15 / (1 << 14);
inline constexpr double lean_faithful_off_surface_share_of_extent = 0.19 / (1 << 14);
// Whether both hold. pre: triangles refer to vertices
bool is_faithful(const mesh::Mesh& level, double normal_error_degrees);
// And no step is larger than this share of the mean edge.
inline constexpr double steps_per_edge = 8.0;

// The grid from the corner of `bounds` on with about the largest step that keeps `level`, which is `error` (RMS, model
// units) and whose normals are `normal_error_degrees` off the full model, within these limits if it is rounded along
// its surface. It may reach beyond `bounds`: the codes that are left over cost nothing, half a bit of each coordinate
// would. pre: `bounds` holds the level
QuantizationGrid fit_grid(const Box& bounds, const mesh::Mesh& level, double error, double normal_error_degrees,
                          bool lean = false);

// For content that must meet other content, and so is rounded to the nearest point: the step always resolves 1/16 of
// the mean edge, and never more than 1/64 of it: a finer one no longer tilts a triangle by as much as 8-bit normals do,
// and its bytes buy less than the same bytes of triangles would.
inline constexpr double coarsest_steps_per_edge = 16.0;
inline constexpr double finest_steps_per_edge = 64.0;

// The grid around `bounds` whose step moves a vertex by at most a quarter of `error` within the limits above. Levels of
// one asset that are given the same `bounds` differ in `bits` alone. Where neither length is positive: the most bits.
QuantizationGrid choose_grid(const Box& bounds, double error, double mean_edge_length);

// A window around `bounds` of the one lattice whose points are whole multiples of a power of two, the greatest that is
// not above choose_grid()'s step. Windows of one step decode a position that they share to the same bits, and a small
// part of a large scene needs no more bits for being far from its middle.
QuantizationGrid choose_window(const Box& bounds, double error, double mean_edge_length);
// The same of the greatest power of two that is not above `step`, or of the finest that there is; 0: that one.
QuantizationGrid window_of_step(const Box& bounds, double step);

// An image to be sent in place of one of the model's.
struct SmallerImage {
    const mesh::Image* image = nullptr;     // null: the model's own
    std::uint64_t bytes_below_a_pixel = 0;  // of the bytes saved, those that the display could not have shown
};

enum class Rounding {
    nearest,        // half a step at most on each axis, by the position alone: what must meet other content bit for bit
    along_surface,  // one and a half at most: to where the surface moves least (common/codec/rounding.h)
};

struct EncodeOptions {
    QuantizationGrid grid;
    Rounding rounding = Rounding::along_surface;
    bool lean = false;
    int normal_bits = 8;  // plain only
    // What a Gouraud normal may be off by, and three times that where its face is farther off: those that its triangles
    // tell as well are not sent, or cost next to nothing. 0: as close as they can be sent.
    double normal_tolerance_degrees = 0.0;
    int texture_coordinate_bits = 12;  // at most; fewer where a step would be finer than a quarter of a texel
    std::vector<SmallerImage> images;  // one for each of the model's; empty: all as they are
    std::string extras_json;           // an object, put into the asset's `extras.lodestream`; empty: none
};

// In proportion to what the level's normals are off anyway (metric::SurfaceError::normal_degrees), within limits.
double fit_normal_tolerance_degrees(double normal_error_degrees, bool lean = false);
// Bits of a plain level's normals that keep this many steps in the tolerance, within which a derived one is, rounded
// towards zero. One that is told goes to the nearest, so where most are, fewer are enough: at most 8, and one less
// where even the largest tolerance leaves them to be told (boxes whose corners were merged). pre: > 0
inline constexpr double normal_steps_per_tolerance = 2.84;
inline constexpr int most_normal_bits = 9, most_told_normal_bits = 8;
int fit_normal_bits(double tolerance_degrees, bool most_are_told = false);
inline constexpr double normal_tolerance_share_of_error = 0.55, lean_normal_tolerance_share_of_error = 0.6;
inline constexpr double least_normal_tolerance_degrees = 0.5;
inline constexpr double least_lean_normal_tolerance_degrees = 0.42;
inline constexpr double largest_normal_tolerance_degrees = 8.0;

// Sets both, for a lean level where `options` say so.
void fit_normals(EncodeOptions& options, const mesh::Mesh& level, double normal_error_degrees);

struct Encoded {
    std::vector<std::byte> glb;
    std::uint64_t triangles = 0;
    std::uint64_t vertices = 0;                                   // as decoded, summed over the primitives
    std::uint64_t geometry_bytes = 0;                             // of the streams and the lean shading
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
// with `level`: same triangles, positions as near as `rounding` says, borders identical. Errors: invalid_input (too
// many triangles, not finite), internal.
Result<Encoded> encode_level(const mesh::Model& model, const mesh::Mesh& level, std::span<const std::uint8_t> gouraud,
                             const EncodeOptions& options);

inline constexpr std::uint64_t max_decoded_triangles = 100'000'000;
inline constexpr std::uint64_t max_decoded_vertices = 100'000'000;

// Reads what encode_level wrote. The bytes are hostile: any damage is an error, never a crash or an unbounded
// allocation.
Result<Decoded> decode_level(std::span<const std::byte> glb);

}  // namespace lodestream::codec
