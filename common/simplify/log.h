// What the recording engine writes down, fine to coarse; assemble() turns it around into a History.
#pragma once

#include <cstdint>
#include <vector>

#include "common/simplify/history.h"
#include "common/simplify/wedges.h"

namespace lodestream::simplify {

// The steps that one worker makes, in its order. Each can be undone from what stands here and from what the surface
// remembers of what has gone (a face's last corners, a wedge's last attributes).
struct Log {
    // Where the step's entries end. `key`: steps are put in its order; never below
    // that of a step it builds on.
    struct Head {
        float key;
        std::uint32_t deaths, changes, corners, faces;
    };
    struct Death {
        std::uint32_t wedge;
        std::uint32_t corners;  // of this step's corner moves, how many are away from this wedge
    };
    std::vector<Head> heads;
    std::vector<Death> deaths;           // wedges that go
    std::vector<std::uint32_t> changed;  // wedges that get other values, and below what they had before
    std::vector<Vec3f> positions;        // scaled as Geometry's points
    std::vector<Vec3f> normals;
    std::vector<Vec2f> texture_coordinates;
    std::vector<Rgba8> colors;
    std::vector<std::uint32_t> corners;  // 3 * face + k
    std::vector<std::uint32_t> faces;    // that go

    // Room for a number of ordinary merges.
    void reserve(std::size_t merges, const Wedges& wedges) {
        constexpr std::size_t usual_corner_moves = 4;
        heads.reserve(merges);
        deaths.reserve(merges);
        changed.reserve(merges);
        positions.reserve(merges);
        if (wedges.has_normals()) normals.reserve(merges);
        if (wedges.has_texture_coordinates()) texture_coordinates.reserve(merges);
        if (wedges.has_colors()) colors.reserve(merges);
        corners.reserve(usual_corner_moves * merges);
        faces.reserve(2 * merges);
    }

    void end_step(float key) {
        heads.push_back({key, static_cast<std::uint32_t>(deaths.size()), static_cast<std::uint32_t>(changed.size()),
                         static_cast<std::uint32_t>(corners.size()), static_cast<std::uint32_t>(faces.size())});
    }
    Head before(std::size_t step) const { return step == 0 ? Head{} : heads[step - 1]; }
    void add_change(std::uint32_t wedge, const Vec3f& position, const Wedges& wedges) {
        changed.push_back(wedge);
        positions.push_back(position);
        const Attributes a = wedges.attributes(wedge);
        if (wedges.has_normals()) normals.push_back(a.normal);
        if (wedges.has_texture_coordinates()) texture_coordinates.push_back(a.texture_coordinate);
        if (wedges.has_colors()) colors.push_back(a.color);
    }
};

}  // namespace lodestream::simplify
