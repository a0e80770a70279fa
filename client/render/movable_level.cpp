#include "client/render/movable_level.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "client/render/scene.h"
#include "client/render/vertex_order.h"
#include "common/mesh/operations.h"
#include "common/shading/importance.h"

namespace lodestream::render {
namespace {

constexpr std::size_t max_compared_corners = 64;  // at one position; beyond, every corner there takes the whole average

// Things grouped by position: things[first[p] … first[p + 1]).
struct ByPosition {
    std::vector<std::uint32_t> first, things;

    std::span<const std::uint32_t> at(std::uint32_t position) const {
        return std::span(things).subspan(first[position], first[position + 1] - first[position]);
    }
};

ByPosition group(const std::vector<std::uint32_t>& position_of, std::size_t positions,
                 const std::vector<std::uint32_t>& things) {
    ByPosition by;
    by.first.assign(positions + 1, 0);
    for (const std::uint32_t thing : things) ++by.first[position_of[thing] + 1];
    for (std::size_t p = 0; p < positions; ++p) by.first[p + 1] += by.first[p];
    by.things.resize(things.size());
    std::vector<std::uint32_t> next(by.first.begin(), by.first.end() - 1);
    for (const std::uint32_t thing : things) by.things[next[position_of[thing]]++] = thing;
    return by;
}

// Every triangle's corners one after the other, with what they bring; flat ones without a normal yet.
struct Soup {
    mesh::Mesh mesh;                   // vertex 3 t + k is corner k of triangle t
    std::vector<std::uint8_t> smooth;  // of the triangles: came with normals
};

template <class T>
bool any(const codec::Decoded& content, std::vector<T> mesh::Mesh::*attribute) {
    return std::any_of(content.primitives.begin(), content.primitives.end(),
                       [&](const codec::Primitive& p) { return !(p.mesh.*attribute).empty(); });
}

Soup soup_of(const codec::Decoded& content) {
    Soup soup;
    mesh::Mesh& out = soup.mesh;
    const bool colored = any(content, &mesh::Mesh::colors), textured = any(content, &mesh::Mesh::texture_coordinates);
    for (const codec::Primitive& primitive : content.primitives) {
        const mesh::Mesh& in = primitive.mesh;
        const bool smooth = primitive.shading == codec::Shading::gouraud;
        for (const mesh::Triangle& t : in.triangles) {
            const auto next = static_cast<std::uint32_t>(out.positions.size());
            for (const std::uint32_t v : t) {
                out.positions.push_back(in.positions[v]);
                out.normals.push_back(smooth ? in.normals[v] : Vec3f{0.0f});
                if (colored) out.colors.push_back(in.colors.empty() ? Rgba8(255) : in.colors[v]);
                if (textured)
                    out.texture_coordinates.push_back(in.texture_coordinates.empty() ? Vec2f{0.0f}
                                                                                     : in.texture_coordinates[v]);
            }
            out.triangles.push_back({next, next + 1, next + 2});
            out.triangle_materials.push_back(primitive.material);
            soup.smooth.push_back(smooth ? 1 : 0);
        }
    }
    return soup;
}

// Gives the flat triangles' corners their normals.
class NormalRebuilder {
  public:
    explicit NormalRebuilder(Soup& soup) : soup_(soup), position_(mesh::weld_positions(soup.mesh.positions)) {
        std::vector<std::uint32_t> smooth, flat;
        for (std::uint32_t c = 0; c < position_.size(); ++c) (soup.smooth[c / 3] ? smooth : flat).push_back(c);
        smooth_ = group(position_, position_.size(), smooth);
        flat_ = group(position_, position_.size(), flat);
        for (const mesh::Triangle& t : soup.mesh.triangles) {
            const auto& p = soup.mesh.positions;
            faces_.push_back(mesh::face_normal(p[t[0]], p[t[1]], p[t[2]]));
            areas_.push_back(mesh::face_area(p[t[0]], p[t[1]], p[t[2]]));
        }
    }

    void run() {
        for (std::uint32_t c = 0; c < position_.size(); ++c)
            if (!soup_.smooth[c / 3]) soup_.mesh.normals[c] = normal_of(c);
    }

  private:
    Vec3f normal_of(std::uint32_t corner) const {
        const Vec3d own = faces_[corner / 3];
        const auto border = smooth_.at(position_[corner]);
        double nearest = cos_crease_;
        Vec3f normal{0.0f};
        for (const std::uint32_t c : border.first(std::min(border.size(), max_compared_corners)))
            if (const double along = dot(own, Vec3d(soup_.mesh.normals[c])); along >= nearest) {
                nearest = along;
                normal = soup_.mesh.normals[c];
            }
        return normal != Vec3f{0.0f} ? normal : average(corner, own);
    }

    // Over the faces within the crease, by area; of the faces alone where that is nothing.
    Vec3f average(std::uint32_t corner, const Vec3d& own) const {
        const auto around = flat_.at(position_[corner]);
        const bool compare = around.size() <= max_compared_corners && own != Vec3d{0.0};
        Vec3d sum{0.0};
        for (const std::uint32_t c : around)
            if (!compare || dot(own, faces_[c / 3]) >= cos_crease_) sum += areas_[c / 3] * faces_[c / 3];
        const double size = length(sum);
        return size > 0.0 && std::isfinite(size) ? Vec3f(sum / size) : Vec3f(own);
    }

    Soup& soup_;
    const double cos_crease_ = std::cos(radians(crease_degrees));
    std::vector<std::uint32_t> position_;
    ByPosition smooth_, flat_;
    std::vector<Vec3d> faces_;
    std::vector<double> areas_;
};

// By falling error from bucket to bucket; inside one by material, then for the cache.
std::vector<std::uint32_t> bucketed(const mesh::Mesh& mesh, std::vector<std::uint32_t> order) {
    const std::size_t buckets = std::min(order_buckets, std::max<std::size_t>(order.size(), 1));
    for (std::size_t bucket = 0; bucket < buckets; ++bucket) {
        const auto begin = order.begin() + static_cast<std::ptrdiff_t>(order.size() * bucket / buckets);
        const auto end = order.begin() + static_cast<std::ptrdiff_t>(order.size() * (bucket + 1) / buckets);
        std::stable_sort(begin, end, [&](std::uint32_t a, std::uint32_t b) {
            return mesh.triangle_materials[a] < mesh.triangle_materials[b];
        });
        for (auto first = begin, last = begin; first != end; first = last) {
            const std::uint32_t material = mesh.triangle_materials[*first];
            last = std::find_if(first, end, [&](std::uint32_t t) { return mesh.triangle_materials[t] != material; });
            std::vector<mesh::Triangle> triangles;
            for (auto it = first; it != last; ++it) triangles.push_back(mesh.triangles[*it]);
            std::vector<std::uint32_t> arranged;
            for (const std::uint32_t place : cache_order(triangles)) arranged.push_back(*(first + place));
            std::copy(arranged.begin(), arranged.end(), first);
        }
    }
    return order;
}

mesh::Mesh arranged(mesh::Mesh mesh, const std::vector<std::uint32_t>& order) {
    const std::vector<mesh::Triangle> triangles = std::move(mesh.triangles);
    const std::vector<std::uint32_t> materials = std::move(mesh.triangle_materials);
    mesh.triangles.clear();
    mesh.triangle_materials.clear();
    for (const std::uint32_t t : order) {
        mesh.triangles.push_back(triangles[t]);
        mesh.triangle_materials.push_back(materials[t]);
    }
    return mesh;
}

// Of every material that is used, rising, the places of its triangles.
std::vector<std::vector<std::uint32_t>> places_by_material(const mesh::Mesh& mesh, std::size_t materials) {
    std::vector<std::vector<std::uint32_t>> places(materials);
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) places[mesh.triangle_materials[t]].push_back(t);
    std::erase_if(places, [](const auto& p) { return p.empty(); });
    return places;
}

}  // namespace

Result<MovableLevel> movable_level(const codec::Decoded& content, const shading::Phong& phong) {
    if (auto sound = check_drawable(content); !sound) return sound.error();
    Soup soup = soup_of(content);
    NormalRebuilder(soup).run();
    mesh::Model model;
    model.mesh = mesh::compact(soup.mesh);
    model.materials = content.materials;
    model.images = content.images;
    model.origin = content.origin;

    MovableLevel level;
    level.radius = mesh::bounds(model.mesh).radius();
    const shading::Importance importance = shading::importance(model.mesh, model.materials, {.phong = phong});
    const auto order = bucketed(model.mesh, shading::order_by_gain(importance.gain));
    level.difference_left = shading::difference_left(importance.difference, order);
    const mesh::Mesh mesh = arranged(std::move(model.mesh), order);
    level.places = places_by_material(mesh, content.materials.size());
    level.content = drawable(model, mesh);
    level.content.extras_json = content.extras_json;
    return level;
}

}  // namespace lodestream::render
