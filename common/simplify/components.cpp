#include "common/simplify/components.h"

#include <algorithm>
#include <numeric>

namespace lodestream::simplify {

namespace {

// A part is dropped once a merge costs more than its area times its squared size times this.
constexpr double drop_weight = 3.0;

std::uint32_t root_of(std::vector<std::uint32_t>& parent, std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
}

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

// Numbers the parts by their first face.
void number_parts(const Surface& surface, const std::vector<std::uint32_t>& faces, Components& c) {
    std::vector<std::uint32_t> parent(surface.positions());
    std::iota(parent.begin(), parent.end(), 0u);
    for (const std::uint32_t f : faces) {
        const mesh::Triangle t = positions_of(surface, f);
        for (const std::uint32_t corner : t) {
            const std::uint32_t a = root_of(parent, t[0]), b = root_of(parent, corner);
            parent[std::max(a, b)] = std::min(a, b);
        }
    }
    c.of_position.assign(parent.size(), none);
    for (const std::uint32_t f : faces) {
        std::uint32_t& number = c.of_position[root_of(parent, positions_of(surface, f)[0])];
        if (number == none) {
            number = static_cast<std::uint32_t>(c.live.size());
            c.live.push_back(0);
        }
        ++c.live[number];
    }
    for (std::uint32_t p = 0; p < parent.size(); ++p) c.of_position[p] = c.of_position[root_of(parent, p)];
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
