// Reads a model of any supported format into the one mesh type. Bytes are hostile.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "common/base/result.h"
#include "common/mesh/mesh.h"

namespace lodestream::importer {

enum class Format { gltf, glb, obj, ply, stl, off, drc, terrain_png, terrain_hgt, terrain_asc };

struct Limits {
    std::uint64_t file_bytes = 2ull << 30;
    std::uint64_t vertices = 50'000'000;
    std::uint64_t triangles = 50'000'000;
    std::uint64_t shown_triangles = 1'000'000'000;  // those of a shape counted with each of its instances
    std::uint64_t nodes = 1'000'000;
    std::uint32_t node_depth = 4'096;
    std::uint64_t image_bytes = 256ull << 20;
    std::uint32_t image_side = 16'384;  // texels
};

// Of a mesh that is kept once where several nodes show it, and that this saves: beside fewer, tiles of their own cost
// more.
inline constexpr std::uint64_t least_shared_triangles = 500, least_saved_triangles = 7'500;

inline constexpr double crease_degrees = 60.0;  // edges sharper than this stay hard where a file brings no normals

// By extension, any case; nullopt-like error `unsupported` that names the extension.
Result<Format> format_of_extension(const std::filesystem::path& file);
// By content, for uploads without a telling name: magic numbers and first words. Error: unsupported.
Result<Format> sniff_format(std::span<const std::byte> bytes);

// Fetches a side file (buffer, image, material library) by the relative name that the model gives. Absolute names,
// `..` beyond the model's folder and URLs are refused by read_file_below().
using SideFiles = std::function<Result<std::vector<std::byte>>(const std::string& relative_name)>;
SideFiles read_files_below(const std::filesystem::path& folder, std::uint64_t max_bytes);
SideFiles no_side_files();

// The model in world space: node transforms applied, meshes and primitives joined, quantized, sparse, Draco and meshopt
// data expanded, polygons triangulated, positions relative to Model::origin, normals made where there are none, and
// compact (mesh/operations.h): non-finite, out-of-range and degenerate triangles are dropped with a warning that counts
// them. A PLY file without faces is a cloud (mesh::Kind::points): positions, normals and colours as they are, the
// finite ones. Other files with points but no triangles, and those with no geometry at all, are errors that say so.
// A glTF mesh that several nodes or EXT_mesh_gpu_instancing show is a shape with instances, in its own coordinates,
// where that saves enough; mirrored ones show a shape of their own, so that no matrix mirrors. Nodes
// with a skin, or whose matrix scene::validate() refuses (flattened to nothing, beyond its bounds), have their
// triangles in the mesh as all others do. Skins, morph targets and animations are taken in their rest pose with a
// warning. Errors name the file or element: invalid_input, unsupported, limit_exceeded, not_found (side files).
Result<mesh::Model> import_model(std::span<const std::byte> bytes, Format format, const SideFiles& side_files,
                                 const Limits& limits = {});
Result<mesh::Model> import_file(const std::filesystem::path& file, const Limits& limits = {});

}  // namespace lodestream::importer
