#include "server/bake/hlod.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <numeric>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "common/mesh/operations.h"
#include "common/metric/surface_distance.h"
#include "common/scene/hierarchy.h"
#include "common/scene/surroundings.h"
#include "server/bake/bake.h"
#include "server/bake/executor.h"
#include "server/bake/scene_colors.h"
#include "server/bake/scene_source.h"
#include "server/bake/seen_surface.h"
#include "server/bake/textures.h"

namespace lodestream::bake {

namespace {

// The triangles of each object: order[first[object] … first[object + 1]).
struct TrianglesByObject {
    std::vector<std::uint32_t> first;
    std::vector<std::uint32_t> order;

    std::span<const std::uint32_t> of(std::uint32_t object) const {
        return std::span(order).subspan(first[object], first[object + 1] - first[object]);
    }
};

TrianglesByObject sort_by_object(const mesh::Mesh& mesh, std::size_t objects) {
    TrianglesByObject by;
    by.first.assign(objects + 1, 0);
    for (const std::uint32_t object : mesh.triangle_objects) ++by.first[object + 1];
    std::partial_sum(by.first.begin(), by.first.end(), by.first.begin());
    by.order.resize(mesh.triangles.size());
    std::vector<std::uint32_t> next(by.first.begin(), by.first.end() - 1);
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) by.order[next[mesh.triangle_objects[t]]++] = t;
    return by;
}

std::vector<scene::Object> describe_objects(const mesh::Model& model, const TrianglesByObject& triangles) {
    std::vector<scene::Object> objects(model.graph.object_nodes.size());
    for (std::uint32_t i = 0; i < objects.size(); ++i) {
        objects[i].graph_node = model.graph.object_nodes[i];
        objects[i].triangles = triangles.of(i).size();
        for (const std::uint32_t t : triangles.of(i))
            for (const std::uint32_t v : model.mesh.triangles[t]) objects[i].box.add(Vec3d(model.mesh.positions[v]));
    }
    return objects;
}

struct Tile {
    scene::LodNode node;  // without its place in the tree
    std::string hash;
    std::uint64_t bytes = 0;
};

// What a node of the hierarchy has become: tiles that follow each other from the finest to the coarsest, and the mesh
// of that one until the tile above is made.
struct Branch {
    std::vector<Tile> tiles;
    Surface surface;
};

// Of a tile, among those that the branches have become.
struct Place {
    std::uint32_t branch, tile;
};

class TileMaker {
  public:
    TileMaker(store::Store& store, const std::string& asset_id, const mesh::Model& model,
              const texture::Textures& textures, const std::function<bool(double)>& progress)
        : store_(store),
          asset_id_(asset_id),
          model_(model),
          textures_(textures),
          progress_(progress),
          triangles_(sort_by_object(model.mesh, model.graph.object_nodes.size())),
          may_paint_(can_be_painted(model.materials)) {
        scene::HierarchyOptions options;
        options.leaf_triangles = tile_triangles;
        options.max_children = max_tile_children;
        hierarchy_ = scene::build_hierarchy(describe_objects(model, triangles_), model.graph.parents, options);
        branches_.resize(hierarchy_.nodes.size());
        if (may_paint_ && hierarchy_.nodes.size() > 1) {
            const scene::Surroundings around(model.mesh, scene::max_cells);
            colors_.emplace(model, mesh::part(model.mesh, around.visible_triangles()));
        }
    }

    Result<TileTree> make() {
        for (const std::vector<std::uint32_t>& wave : waves()) {
            const simplify::Executor executor = all_cores(), none;
            executor(wave.size(), [&](std::size_t i) { make_branch(wave[i], wave.size() == 1 ? executor : none); });
            if (error_) return *error_;
        }
        TileTree tiles = tree();
        if (Status kept = keep_objects(); !kept) return kept.error();
        return tiles;
    }

  private:
    // Nodes whose children are all in waves before.
    std::vector<std::vector<std::uint32_t>> waves() const {
        std::vector<std::size_t> heights(hierarchy_.nodes.size(), 0);
        std::vector<std::vector<std::uint32_t>> waves;
        for (std::size_t i = hierarchy_.nodes.size(); i-- > 0;) {
            const scene::HierarchyNode& node = hierarchy_.nodes[i];
            if (waves.size() <= heights[i]) waves.resize(heights[i] + 1);
            waves[heights[i]].push_back(static_cast<std::uint32_t>(i));
            if (node.parent != scene::none) heights[node.parent] = std::max(heights[node.parent], heights[i] + 1);
        }
        return waves;
    }

    void make_branch(std::uint32_t index, const simplify::Executor& executor) {
        if (stopped_) return;
        const Status made =
            hierarchy_.nodes[index].child_count == 0 ? make_leaf(index, executor) : make_inner(index, executor);
        if (!made) return stop(made.error());
        if (!report(1.0)) stop(fail(ErrorCode::unavailable, "the bake was ended"));
    }

    void stop(const Error& error) {
        const std::lock_guard lock(mutex_);
        if (!error_) error_ = error;
        stopped_ = true;
    }

    bool report(double nodes) {
        const std::lock_guard lock(mutex_);
        done_ += nodes;
        return progress_(std::min(1.0, done_ / static_cast<double>(hierarchy_.nodes.size())));
    }

    Status make_leaf(std::uint32_t index, const simplify::Executor& executor) {
        const scene::HierarchyNode& node = hierarchy_.nodes[index];
        std::vector<std::uint32_t> triangles;
        for (std::uint32_t i = 0; i < node.object_count; ++i) {
            const auto more = triangles_.of(hierarchy_.objects[node.first_object + i]);
            triangles.insert(triangles.end(), more.begin(), more.end());
        }
        std::sort(triangles.begin(), triangles.end());
        mesh::Mesh source = mesh::part(model_.mesh, triangles);
        source.triangle_objects.clear();
        if (Status added = add_tile(index, {source, false}, {}); !added) return added;

        std::vector<std::uint64_t> counts;
        add_chain(counts, source.triangles.size(), index == 0 ? coarsest_tile : tile_triangles);
        branches_[index].surface.mesh = source;
        if (counts.empty()) return Nothing{};
        SeenSurface itself{{}, {}, metric::SurfaceIndex(source, samples_of(source))};
        itself.surfaces.push_back({std::move(source), false});
        return add_levels(index, std::move(itself), counts, executor);
    }

    // Tiles are cut from what is seen of the tiles below, or from the surface wrapped around it.
    Status make_inner(std::uint32_t index, const simplify::Executor& executor) {
        Surface below = joined_children(index);
        const std::vector<std::uint64_t> counts = tile_counts(below.mesh.triangles.size(), index == 0);
        SeenSurface seen = seen_from_outside(below, counts.front(), may_paint_);
        below = {};
        return add_levels(index, std::move(seen), counts, executor);
    }

    Surface joined_children(std::uint32_t index) {
        const scene::HierarchyNode& node = hierarchy_.nodes[index];
        const std::span children = std::span(branches_).subspan(node.first_child, node.child_count);
        Surface joined;
        joined.is_bare =
            std::any_of(children.begin(), children.end(), [](const Branch& child) { return child.surface.is_bare; });
        for (Branch& child : children) {
            const Surface surface = std::exchange(child.surface, {});
            mesh::append(joined.mesh, joined.is_bare && !surface.is_bare ? bare(surface.mesh) : surface.mesh);
        }
        joined.mesh = mesh::compact(mesh::part(joined.mesh, mesh::distinct_triangles(joined.mesh)));
        return joined;
    }

    // Adds a tile of each of these counts, each on top of the one before.
    Status add_levels(std::uint32_t index, SeenSurface seen, const std::vector<std::uint64_t>& counts,
                      const simplify::Executor& executor) {
        Branch& branch = branches_[index];
        const std::uint64_t finer =
            branch.tiles.empty() ? scene::max_tree_triangles : branch.tiles.back().node.triangles;
        Result<std::vector<TileLevel>> levels =
            cut_levels(std::move(seen), counts, finer, executor, [&] { return report(0.0); });
        if (!levels) return levels.error();
        for (TileLevel& level : *levels) {
            if (Status added = add_tile(index, level.surface, level.error); !added) return added;
            branch.surface = std::move(level.surface);
        }
        return Nothing{};
    }

    // Tiles directly below the one that a branch gets next.
    std::vector<const Tile*> tiles_below(std::uint32_t index) const {
        if (!branches_[index].tiles.empty()) return {&branches_[index].tiles.back()};
        const scene::HierarchyNode& node = hierarchy_.nodes[index];
        std::vector<const Tile*> tiles;
        for (std::uint32_t i = 0; i < node.child_count; ++i)
            tiles.push_back(&branches_[node.first_child + i].tiles.back());
        return tiles;
    }

    // What the mesh that a branch's tiles are cut from is off by itself.
    double source_error(std::uint32_t index) const {
        const scene::HierarchyNode& node = hierarchy_.nodes[index];
        double error = 0.0;
        for (std::uint32_t i = 0; i < node.child_count; ++i)
            error = std::max(error, branches_[node.first_child + i].tiles.back().node.error);
        return error;
    }

    // `error`: against the mesh that the branch's tiles are cut from.
    Status add_tile(std::uint32_t index, const Surface& surface, const metric::SurfaceError& error) {
        const Box bounds = mesh::bounds(surface.mesh);
        Tile tile;
        tile.node.triangles = surface.mesh.triangles.size();
        tile.node.error = error.max;
        if (!tiles_below(index).empty())
            tile.node.error += source_error(index) + rounding_error(tile_grid(surface.mesh, error));
        tile.node.box = {bounds.min + model_.origin, bounds.max + model_.origin};
        for (const Tile* below : tiles_below(index)) {
            tile.node.error = std::max(tile.node.error, below->node.error);
            tile.node.box.add(below->node.box.min);
            tile.node.box.add(below->node.box.max);
        }
        Result<codec::Encoded> encoded =
            encode_tile(surface, error, model_, texture::choose(model_, textures_, level_needs(error)).images,
                        colors_ ? &*colors_ : nullptr);
        if (!encoded) return encoded.error();
        std::vector<Tile>& tiles = branches_[index].tiles;
        Result<store::StoredFile> file =
            store_.put_content(asset_id_, tile_key(index, tiles.size()), "glb", encoded->glb);
        if (!file) return file.error();
        tile.hash = file->hash;
        tile.bytes = file->bytes;
        tiles.push_back(std::move(tile));
        return Nothing{};
    }

    // So that they can be changed later.
    Status keep_objects() {
        std::vector<std::uint32_t> tile_of_object(model_.graph.object_nodes.size(), no_tile);
        for (std::uint32_t tile = 0; tile < places_.size(); ++tile) {
            const scene::HierarchyNode& node = hierarchy_.nodes[places_[tile].branch];
            if (places_[tile].tile > 0 || node.child_count > 0) continue;
            for (std::uint32_t i = 0; i < node.object_count; ++i)
                tile_of_object[hierarchy_.objects[node.first_object + i]] = tile;
        }
        std::vector<std::span<const std::uint32_t>> triangles;
        for (std::uint32_t i = 0; i < tile_of_object.size(); ++i) triangles.push_back(triangles_.of(i));
        if (auto kept = put_scene_source(store_, asset_id_, model_, triangles, tile_of_object); !kept)
            return kept.error();
        return Nothing{};
    }

    // Root first, children side by side and after their parent.
    TileTree tree() {
        TileTree tree;
        const auto add = [&](Place place, std::uint32_t parent) {
            const Tile& tile = branches_[place.branch].tiles[place.tile];
            places_.push_back(place);
            tree.nodes.push_back(tile.node);
            tree.nodes.back().parent = parent;
            tree.hashes.push_back(tile.hash);
            tree.bytes.push_back(tile.bytes);
        };
        const auto coarsest = [&](std::uint32_t branch) {
            return Place{branch, static_cast<std::uint32_t>(branches_[branch].tiles.size() - 1)};
        };
        add(coarsest(0), scene::none);
        for (std::uint32_t i = 0; i < tree.nodes.size(); ++i) {
            const auto first = static_cast<std::uint32_t>(tree.nodes.size());
            const Place place = places_[i];
            const scene::HierarchyNode& node = hierarchy_.nodes[place.branch];
            if (place.tile > 0)
                add({place.branch, place.tile - 1}, i);
            else
                for (std::uint32_t k = 0; k < node.child_count; ++k) add(coarsest(node.first_child + k), i);
            tree.nodes[i].first_child = tree.nodes.size() > first ? first : 0;
            tree.nodes[i].child_count = static_cast<std::uint32_t>(tree.nodes.size()) - first;
        }
        return tree;
    }

    store::Store& store_;
    const std::string& asset_id_;
    const mesh::Model& model_;
    const texture::Textures& textures_;
    const std::function<bool(double)>& progress_;
    TrianglesByObject triangles_;
    bool may_paint_;
    std::optional<SceneColors> colors_;
    scene::Hierarchy hierarchy_;
    std::vector<Branch> branches_;  // of each node of the hierarchy
    std::vector<Place> places_;     // of each tile of the tree
    std::atomic<bool> stopped_{false};
    std::mutex mutex_;
    double done_ = 0.0;  // nodes
    std::optional<Error> error_;
};

}  // namespace

Result<TileTree> make_tiles(store::Store& store, const std::string& asset_id, const mesh::Model& model,
                            const texture::Textures& textures, const std::function<bool(double)>& progress) {
    Result<TileTree> tree = TileMaker(store, asset_id, model, textures, progress).make();
    if (!tree) return tree;
    if (Status valid = scene::validate(tree->nodes); !valid)
        return fail(ErrorCode::internal, "the tiles make no tree: " + valid.error().message);
    if (auto file = store.put_content(asset_id, tiles_key, "tiles", serialize(*tree)); !file) return file.error();
    return tree;
}

}  // namespace lodestream::bake
