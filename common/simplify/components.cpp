#include "common/simplify/components.h"

#include <algorithm>
#include <numeric>

namespace lodestream::simplify {

namespace {

// A part is dropped once a merge costs more than its area times its squared size times this.
constexpr double drop_weight = 3.0;

mesh::Triangle positions_of(const Surface& surface, std::uint32_t face) {
    mesh::Triangle t = surface.face_wedges(face);
    for (std::uint32_t& corner : t) corner = surface.position_of_wedge(corner);
    return t;
}

std::vector<std::uint32_t> live_faces(const Surface& surface) {
    std::vector<std::uint32_t> faces;
    for (std::uint32_t f = 0; f < surface.faces(); ++f)
        if (surface.is_live(f)) faces.push_back(f);
    return faces;
}

// The lowest position connected with `i`, which every position leads to by way of lower ones.
std::uint32_t root_of(std::vector<std::uint32_t>& lower, std::uint32_t i) {
    while (lower[i] != i) i = lower[i] = lower[lower[i]];
    return i;
}

// Numbers the parts by their lowest position.
void number_parts(const Surface& surface, const std::vector<std::uint32_t>& faces, Components& c) {
    std::vector<std::uint32_t>& lower = c.of_position;
    lower.assign(surface.positions(), none);
    for (const std::uint32_t f : faces)
        for (const std::uint32_t corner : positions_of(surface, f)) lower[corner] = corner;
    for (const std::uint32_t f : faces) {
        const mesh::Triangle t = positions_of(surface, f);
        for (const std::uint32_t corner : t) {
            const std::uint32_t a = root_of(lower, t[0]), b = root_of(lower, corner);
            lower[std::max(a, b)] = std::min(a, b);
        }
    }
    std::uint32_t parts = 0;
    for (std::uint32_t p = 0; p < lower.size(); ++p)
        if (lower[p] != none) lower[p] = lower[p] == p ? parts++ : lower[lower[p]];
    c.live.assign(parts, 0);
    for (const std::uint32_t f : faces) ++c.live[c.of_position[positions_of(surface, f)[0]]];
}

void rank_parts(const Surface& surface, Components& c) {
    for (std::size_t part = 0; part < c.live.size(); ++part) {
        Box box;
        double area = 0;
        for (std::uint32_t i = c.first_face[part]; i < c.first_face[part + 1]; ++i) {
            area += surface.area(c.faces[i]);
            for (const std::uint32_t corner : positions_of(surface, c.faces[i])) box.add(Vec3d(surface.place(corner)));
        }
        const Vec3d extent = box.extent();
        c.visibility.push_back(drop_weight * area * dot(extent, extent));
    }
    c.by_visibility.resize(c.live.size());
    std::iota(c.by_visibility.begin(), c.by_visibility.end(), 0u);
    std::stable_sort(c.by_visibility.begin(), c.by_visibility.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return c.visibility[a] < c.visibility[b]; });
}

}  // namespace

Components find_components(const Surface& surface) {
    Components c;
    const std::vector<std::uint32_t> faces = live_faces(surface);
    number_parts(surface, faces, c);
    c.first_face.assign(c.live.size() + 1, 0);
    std::partial_sum(c.live.begin(), c.live.end(), c.first_face.begin() + 1);
    std::vector<std::uint32_t> next(c.first_face.begin(), c.first_face.end() - 1);
    c.faces.resize(faces.size());
    for (const std::uint32_t f : faces) c.faces[next[c.of_position[positions_of(surface, f)[0]]]++] = f;
    rank_parts(surface, c);
    return c;
}

}  // namespace lodestream::simplify
