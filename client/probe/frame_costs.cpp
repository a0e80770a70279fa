#include "client/probe/frame_costs.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/shading/screen_extent.h"

namespace lodestream::probe {

namespace {

constexpr std::size_t costs = 7;
constexpr int most_rounds = 20'000;         // of the fit; 7 x 7 products each
constexpr double settled_share = 1e-9;      // of a cost that no round changes by more
constexpr double negligible_share = 1e-12;  // of the pictures' time: a column that no picture has
constexpr double million = 1e6;

using Row = std::array<double, costs>;

// Units of each cost in a picture: the picture's time is their product.
Row units(const control::Work& work) {
    return {1.0,
            work.triangles / million,
            work.vertices / million,
            work.pixels / million,
            work.shaded_px / million,
            work.textured_px / million,
            work.extent_px / million};
}

// min |A c - 1|² over c >= 0 by coordinate descent: each step is the best value of one cost, the others as they are.
Row least_squares(const std::array<Row, costs>& squares, const Row& sums) {
    Row c{};
    for (int round = 0; round < most_rounds; ++round) {
        double change = 0.0;
        for (std::size_t i = 0; i < costs; ++i) {
            if (!(squares[i][i] > negligible_share)) continue;
            double rest = sums[i];
            for (std::size_t j = 0; j < costs; ++j)
                if (j != i) rest -= squares[i][j] * c[j];
            const double next = std::max(rest / squares[i][i], 0.0);
            change = std::max(change, std::abs(next - c[i]) / std::max(next, 1e-30));
            c[i] = next;
        }
        if (change <= settled_share) break;
    }
    return c;
}

bool reads_image(const codec::Decoded& content, const codec::Primitive& primitive) {
    if (primitive.material >= content.materials.size()) return false;
    const mesh::Material& material = content.materials[primitive.material];
    return material.base_color_texture.image >= 0 || material.emissive_texture.image >= 0;
}

}  // namespace

control::FrameCosts fit_costs(std::span<const TimedPicture> pictures) {
    // Columns are scaled to their largest entry, so that no cost's unit matters.
    Row scale{};
    for (const TimedPicture& picture : pictures) {
        const Row row = units(picture.work);
        for (std::size_t i = 0; i < costs; ++i) scale[i] = std::max(scale[i], row[i] / picture.ms);
    }
    std::array<Row, costs> squares{};
    Row sums{};
    for (const TimedPicture& picture : pictures) {
        Row row = units(picture.work);
        for (std::size_t i = 0; i < costs; ++i) row[i] = scale[i] > 0.0 ? row[i] / picture.ms / scale[i] : 0.0;
        for (std::size_t i = 0; i < costs; ++i) {
            sums[i] += row[i];
            for (std::size_t j = 0; j < costs; ++j) squares[i][j] += row[i] * row[j];
        }
    }
    Row c = least_squares(squares, sums);
    for (std::size_t i = 0; i < costs; ++i) c[i] = scale[i] > 0.0 ? c[i] / scale[i] : 0.0;
    control::FrameCosts out;
    out.fixed_ms = c[0];
    out.per_million_triangles_ms = c[1];
    out.per_million_seen_ms = 0.0;
    out.per_million_vertices_ms = c[2];
    out.per_million_pixels_ms = c[3];
    out.per_million_shaded_ms = c[4];
    out.per_million_textured_ms = c[5];
    out.per_million_extent_ms = c[6];
    return out;
}

control::Work work_of(const codec::Decoded& content, const shading::View& view, const budget::Display& display) {
    control::Work work;
    work.pixels = static_cast<double>(display.width) * display.height;
    shading::ScreenExtents extents(view, display);
    for (const codec::Primitive& primitive : content.primitives) {
        const auto triangles = static_cast<double>(primitive.mesh.triangles.size());
        const shading::ScreenExtent extent = extents.draw(primitive.mesh, content.origin);
        work.triangles += triangles;
        // Of a flat primitive as many as faces, or a few more.
        work.vertices += primitive.shading == codec::Shading::flat
                             ? triangles
                             : static_cast<double>(primitive.mesh.positions.size());
        work.shaded_px += extent.shaded_px;
        if (reads_image(content, primitive)) work.textured_px += extent.shaded_px;
        work.extent_px += extent.extent_px;
    }
    return work;
}

}  // namespace lodestream::probe
