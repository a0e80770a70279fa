// What the recording engine writes down, fine to coarse; assemble() turns it around into a History.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/packed_normal.h"
#include "common/simplify/wedges.h"

namespace lodestream::simplify {

// The steps that one worker makes, in its order. Each can be undone from what stands here and from what the surface
// remembers of what has gone (a face's last corners, a wedge's last attributes).
struct Log {
    static constexpr std::uint32_t max_deaths = (1u << 15) - 1;  // of one step; as many changes

    // `key`: what the step costs or more: it never falls, and is never below that of a step it builds on.
    struct Head {
        float key;
        std::uint32_t deaths : 15, changes : 15, faces : 2;  // how many entries are the step's
    };
    struct Death {
        std::uint32_t wedge;
        std::uint32_t corners;  // how many corners move away from this wedge
    };
    std::vector<Head> heads;
    std::vector<Death> deaths;           // wedges that go
    std::vector<std::uint32_t> changed;  // wedges that get other values, and below what they had before
    std::vector<Vec3f> positions;        // scaled as Geometry's points
    std::vector<std::uint32_t> normals;  // packed
    std::vector<Vec2f> texture_coordinates;
    std::vector<Rgba8> colors;
    std::vector<std::uint32_t> corners;  // 3 * face + k, by the deaths
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

    // Frees the room that was not needed.
    void shrink() {
        heads.shrink_to_fit();
        deaths.shrink_to_fit();
        changed.shrink_to_fit();
        positions.shrink_to_fit();
        normals.shrink_to_fit();
        texture_coordinates.shrink_to_fit();
        colors.shrink_to_fit();
        corners.shrink_to_fit();
        faces.shrink_to_fit();
    }

    float last_key() const { return heads.empty() ? 0.0f : heads.back().key; }

    // pre: key >= last_key(). Every entry since the step before is this step's.
    void end_step(float key) {
        heads.push_back({key, static_cast<std::uint32_t>(deaths.size() - ended_deaths_) & max_deaths,
                         static_cast<std::uint32_t>(changed.size() - ended_changes_) & max_deaths,
                         static_cast<std::uint32_t>(faces.size() - ended_faces_) & 3u});
        ended_deaths_ = deaths.size();
        ended_changes_ = changed.size();
        ended_faces_ = faces.size();
    }
    void add_change(std::uint32_t wedge, const Vec3f& position, const Wedges& wedges) {
        changed.push_back(wedge);
        positions.push_back(position);
        const Attributes a = wedges.attributes(wedge);
        if (wedges.has_normals()) normals.push_back(pack_normal(a.normal));
        if (wedges.has_texture_coordinates()) texture_coordinates.push_back(a.texture_coordinate);
        if (wedges.has_colors()) colors.push_back(a.color);
    }

  private:
    std::size_t ended_deaths_ = 0, ended_changes_ = 0, ended_faces_ = 0;
};

}  // namespace lodestream::simplify
