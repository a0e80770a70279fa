// A scene of plates that fill the picture wherever its cut is: any hole in it shows the background.
#pragma once

#include <algorithm>
#include <map>
#include <vector>

#include "client/render/renderer.h"
#include "client/roam/tiles.h"
#include "common/base/random.h"
#include "common/shading/view.h"
#include "proto/tileset.h"

namespace lodestream::roam::testing {

inline constexpr std::uint64_t tile_bytes = 20;  // of each, encoded

// A tree of squares on the plane y = 0, each divided into four, `levels` deep; side 2^(levels - 1) around the origin.
inline proto::Tileset plates(std::uint32_t levels) {
    const double side = static_cast<double>(1u << (levels - 1)), thick = 0.01 * side;
    proto::Tileset tileset;
    scene::LodNode root;
    root.box = {Vec3d{-side / 2, -thick, -side / 2}, Vec3d{side / 2, thick, side / 2}};
    root.error = levels > 1 ? 0.01 * side : 0.0;
    tileset.nodes.push_back(root);
    double extent = side;
    for (std::size_t first = 0, end = 1, level = 1; level < levels; ++level, extent /= 2) {
        for (std::size_t i = first; i < end; ++i) {
            tileset.nodes[i].first_child = static_cast<std::uint32_t>(tileset.nodes.size());
            tileset.nodes[i].child_count = 4;
            for (int k = 0; k < 4; ++k) {
                scene::LodNode child = tileset.nodes[i];
                child.parent = static_cast<std::uint32_t>(i);
                child.first_child = child.child_count = 0;
                child.error = level + 1 < levels ? child.error / 2 : 0.0;
                const Vec3d middle = child.box.center();
                (k % 2 == 0 ? child.box.max.x : child.box.min.x) = middle.x;
                (k / 2 == 0 ? child.box.max.z : child.box.min.z) = middle.z;
                tileset.nodes.push_back(child);
            }
        }
        first = end;
        end = tileset.nodes.size();
    }
    for (std::size_t i = 0; i < tileset.nodes.size(); ++i) {
        tileset.nodes[i].triangles = 2;
        tileset.uris.push_back("/" + std::to_string(i));
        tileset.bytes.push_back(tile_bytes);
    }
    return tileset;
}

// Of a node: its square, of a colour that goes with its place in the tree and has no green.
inline codec::Decoded plate(const proto::Tileset& tileset, std::uint32_t node) {
    const Box& box = tileset.nodes[node].box;
    const auto at = [](double x, double z) { return Vec3f(Vec3d{x, 0.0, z}); };
    codec::Decoded content;
    content.materials.emplace_back();
    content.materials[0].base_color = {0.2f + 0.15f * static_cast<float>(node % 5), 0.0f, node % 2 ? 1.0f : 0.3f, 1.0f};
    mesh::Mesh mesh;
    mesh.positions = {at(box.min.x, box.min.z), at(box.min.x, box.max.z), at(box.max.x, box.max.z),
                      at(box.max.x, box.min.z)};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    content.primitives.push_back({codec::Shading::flat, 0, std::move(mesh)});
    return content;
}

// Hands tiles over at once, or as late and as badly as asked for.
class FakeTiles : public Tiles {
  public:
    explicit FakeTiles(const proto::Tileset& tileset) : scene_(tileset.nodes.front().box), tileset_(&tileset) {}

    void adopt(const proto::Tileset& tileset) override {
        tileset_ = &tileset;
        wanted_.clear();
    }

    void want(std::span<const std::uint32_t> nodes, double) override {
        largest_request = std::max(largest_request, nodes.size());
        for (const std::uint32_t node : nodes) {
            const bool is_new = std::ranges::count(wanted_, node) == 0;
            asked[node] += is_new ? 1 : 0;
        }
        wanted_.assign(nodes.begin(), nodes.end());
    }

    std::vector<Arrival> take(double) override {
        std::vector<Arrival> arrivals;
        std::vector<std::uint32_t> later;
        for (const std::uint32_t node : wanted_)
            if (random.uniform() < delay)
                later.push_back(node);
            else
                arrivals.push_back(arrival(node));
        std::reverse(arrivals.begin(), arrivals.end());
        wanted_ = std::move(later);
        return arrivals;
    }

    double delay = 0.0;  // how probable it is that a tile does not come in a frame
    std::map<std::uint32_t, Error> failing;
    Random random{5};
    std::map<std::uint32_t, int> asked;  // how often, of each node
    std::size_t largest_request = 0;

  private:
    Arrival arrival(std::uint32_t node) const {
        if (const auto error = failing.find(node); error != failing.end()) return {node, error->second};
        return {node, render::prepare(plate(*tileset_, node), scene_)};
    }

    const Box scene_;
    const proto::Tileset* tileset_;
    std::vector<std::uint32_t> wanted_;
};

}  // namespace lodestream::roam::testing
