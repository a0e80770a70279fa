// The readers of the formats. Each fills a Soup from hostile bytes; what is common to all comes after, in finish().
#pragma once

#include <span>
#include <string>

#include "common/base/result.h"
#include "server/importer/importer.h"
#include "server/importer/soup.h"

namespace lodestream::importer {

struct Source {
    std::span<const std::byte> bytes;
    const SideFiles& side_files;
    const Limits& limits;
    std::string stem;  // the file's name without folder and extension; empty for uploads
};

Status read_gltf(const Source& source, Soup& soup);
Status read_glb(const Source& source, Soup& soup);
Status read_obj(const Source& source, Soup& soup);
Status read_ply(const Source& source, Soup& soup);
Status read_stl(const Source& source, Soup& soup);
Status read_off(const Source& source, Soup& soup);
Status read_drc(const Source& source, Soup& soup);

// Terrain lies in the xz plane with heights along y, x to the east and z to the south, in metres.
// 16-bit grey PNG brings no scale: 1 m between samples and png_metres_per_level a grey level, which a warning states.
inline constexpr double png_metres_per_level = 0.01;
Status read_terrain_png(const Source& source, Soup& soup);
Status read_terrain_hgt(const Source& source, Soup& soup);
Status read_terrain_asc(const Source& source, Soup& soup);

// Reads a material library into soup.materials; warnings only.
void read_mtl(const Source& source, const std::string& name, Soup& soup);

}  // namespace lodestream::importer
