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

#include "common/base/transform.h"
#include "common/mesh/instances.h"
#include "common/mesh/operations.h"
#include "common/metric/surface_distance.h"
#include "common/scene/hierarchy.h"
#include "common/scene/placement.h"
#include "common/scene/surroundings.h"
#include "server/bake/bake.h"
#include "server/bake/executor.h"
#include "server/bake/scene_colors.h"
#include "server/bake/scene_source.h"
#include "server/bake/seen_surface.h"
#include "server/bake/textures.h"
#include "server/bake/tile_borders.h"

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
    for (const mesh::Instance& instance : model.instances) {
        objects[instance.object].triangles = model.shapes[instance.shape].triangles.size();
        objects[instance.object].box = mesh::bounds(model.shapes[instance.shape], instance);
    }
    return objects;
}

constexpr std::uint32_t no_instance = 0xffffffffu;

std::vector<std::uint32_t> instances_of_objects(const mesh::Model& model) {
    std::vector<std::uint32_t> instances(model.graph.object_nodes.size(), no_instance);
    for (std::uint32_t i = 0; i < model.instances.size(); ++i) instances[model.instances[i].object] = i;
    return instances;
}

// What shapes are encoded with: their own coordinates begin at 0.
mesh::Model without_place(const mesh::Model& model) {
    mesh::Model shapes;
    shapes.materials = model.materials;
    shapes.images = model.images;
    return shapes;
}

struct Tile {
    scene::LodNode node;  // without its place in the tree
    std::string hash;
    std::uint64_t bytes = 0;
    Mat4d matrix{1.0};  // from the content's coordinates to the world's
};

// What a node of the hierarchy has become: tiles that follow each other from the finest to the coarsest, and the mesh
// of that one until the tile above is made; of an instance, that is its shape's stand-in.
struct Branch {
    std::vector<Tile> tiles;
    Surface surface;
    double surface_error = 0.0;  // of `surface`
    const mesh::Instance* instance = nullptr;
};

// Of a tile, among those that the branches have become.
struct Place {
    std::uint32_t branch, tile;
};

class TileMaker {
  public:
    TileMaker(store::Store& store, const std::string& asset_id, const SceneParts& scene,
              const texture::Textures& textures, const std::function<bool(double)>& progress)
        : store_(store),
          asset_id_(asset_id),
          model_(scene.model),
          shapes_model_(without_place(scene.model)),
          shapes_(scene.shapes),
          textures_(textures),
          progress_(progress),
          triangles_(sort_by_object(model_.mesh, model_.graph.object_nodes.size())),
          may_paint_(can_be_painted(model_.materials)) {
        scene::HierarchyOptions options;
        options.leaf_triangles = tile_triangles;
        options.max_children = max_tile_children;
        hierarchy_ = scene::build_hierarchy(describe_objects(model_, triangles_), model_.graph.parents, options);
        split_leaves();
        if (may_paint_ && hierarchy_.nodes.size() > 1) {
            const scene::Surroundings around(scene.whole, scene::max_cells);
            colors_.emplace(model_, mesh::part(scene.whole, around.visible_triangles()));
        }
    }

    Result<TileTree> make() {
        borders_.emplace(model_.mesh, triangles_of_leaves(), all_cores());
        shape_tiles_.resize(shapes_.size());
        all_cores()(shapes_.size(), [&](std::size_t i) {
            if (Status made = make_shape(i); !made) stop(made.error());
        });
        if (error_) return *error_;
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
    // Every instance becomes a leaf of its own, and the other objects of its leaf one more.
    void split_leaves() {
        const std::vector<std::uint32_t> instances = instances_of_objects(model_);
        const auto leaves_end = static_cast<std::uint32_t>(hierarchy_.nodes.size());
        for (std::uint32_t i = 0; i < leaves_end; ++i)
            if (hierarchy_.nodes[i].child_count == 0) split_leaf(i, instances);
        branches_.resize(hierarchy_.nodes.size());
        for (std::size_t i = 0; i < branches_.size(); ++i) {
            const scene::HierarchyNode& node = hierarchy_.nodes[i];
            if (node.child_count > 0 || node.object_count != 1) continue;
            const std::uint32_t instance = instances[hierarchy_.objects[node.first_object]];
            if (instance != no_instance) branches_[i].instance = &model_.instances[instance];
        }
    }

    void split_leaf(std::uint32_t index, const std::vector<std::uint32_t>& instances) {
        const scene::HierarchyNode leaf = hierarchy_.nodes[index];
        const auto begin = hierarchy_.objects.begin() + leaf.first_object, end = begin + leaf.object_count;
        const auto first_instance =
            std::stable_partition(begin, end, [&](std::uint32_t object) { return instances[object] == no_instance; });
        if (leaf.object_count == 1 || first_instance == end) return;
        const auto add = [&](std::uint32_t first, std::uint32_t count) {
            scene::HierarchyNode child;
            child.parent = index;
            child.first_object = first;
            child.object_count = count;
            hierarchy_.nodes.push_back(child);
        };
        const auto first_child = static_cast<std::uint32_t>(hierarchy_.nodes.size());
        const auto others = static_cast<std::uint32_t>(first_instance - begin);
        if (others > 0) add(leaf.first_object, others);
        for (std::uint32_t k = others; k < leaf.object_count; ++k) add(leaf.first_object + k, 1);
        hierarchy_.nodes[index].first_child = first_child;
        hierarchy_.nodes[index].child_count = static_cast<std::uint32_t>(hierarchy_.nodes.size()) - first_child;
    }

    // Of each node that is a leaf and no instance, rising.
    std::vector<std::vector<std::uint32_t>> triangles_of_leaves() const {
        std::vector<std::vector<std::uint32_t>> all(hierarchy_.nodes.size());
        for (std::size_t i = 0; i < all.size(); ++i) {
            const scene::HierarchyNode& node = hierarchy_.nodes[i];
            if (node.child_count > 0 || branches_[i].instance) continue;
            for (std::uint32_t k = 0; k < node.object_count; ++k) {
                const auto more = triangles_.of(hierarchy_.objects[node.first_object + k]);
                all[i].insert(all[i].end(), more.begin(), more.end());
            }
            std::sort(all[i].begin(), all[i].end());
        }
        return all;
    }

    // The tiles that all instances of a shape have, in its own coordinates.
    Status make_shape(std::size_t index) {
        for (const ShapeLevel& level : shapes_[index]) {
            std::vector<Tile>& tiles = shape_tiles_[index];
            const codec::QuantizationGrid grid = tile_grid(level.mesh, level.error);
            Result<Tile> tile = store_tile({level.mesh, false}, level.error, grid, shapes_model_,
                                           "shape/" + std::to_string(index) + '/' + std::to_string(tiles.size()));
            if (!tile) return tile.error();
            if (!tiles.empty())
                tile->node.error = std::max(tiles.back().node.error, level.error.max + rounding_error(grid));
            tiles.push_back(*std::move(tile));
            if (level.mesh.triangles.size() <= tile_triangles) break;
        }
        return Nothing{};
    }

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
        const Status made = branches_[index].instance                  ? make_instance(index)
                            : hierarchy_.nodes[index].child_count == 0 ? make_leaf(index, executor)
                                                                       : make_inner(index, executor);
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

    Status make_instance(std::uint32_t index) {
        Branch& branch = branches_[index];
        const mesh::Instance& instance = *branch.instance;
        const Mat4d matrix = translation(model_.origin) * instance.matrix;
        const double scale = scene::largest_scale(matrix);
        Box box = mesh::bounds(model_.shapes[instance.shape], instance);
        box = {box.min + model_.origin, box.max + model_.origin};
        for (Tile tile : shape_tiles_[instance.shape]) {
            const Box placed = scene::placed(tile.node.box, matrix);
            if (!branch.tiles.empty()) box.add(placed.min);
            if (!branch.tiles.empty()) box.add(placed.max);
            tile.node.box = box;
            tile.node.error *= scale;
            tile.matrix = matrix;
            branch.tiles.push_back(std::move(tile));
        }
        branch.surface_error =
            std::max(branch.tiles.back().node.error, scale * stand_in(shapes_[instance.shape]).error.max);
        return Nothing{};
    }

    Status make_leaf(std::uint32_t index, const simplify::Executor& executor) {
        mesh::Mesh source = mesh::part(model_.mesh, borders_->triangles(index));
        source.triangle_objects.clear();
        const Surface rounded{borders_->rounded(index, source), false};
        if (Status added = add_tile(index, rounded, {}, borders_->grid(index, rounded.mesh)); !added) return added;

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
            const Surface surface =
                child.instance
                    ? Surface{mesh::placed(stand_in(shapes_[child.instance->shape]).mesh, *child.instance), false}
                    : std::exchange(child.surface, {});
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
            const codec::QuantizationGrid grid = tile_grid(level.surface.mesh, level.error);
            if (Status added = add_tile(index, level.surface, level.error, grid); !added) return added;
            branch.surface = std::move(level.surface);
            branch.surface_error = branch.tiles.back().node.error;
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
            error = std::max(error, branches_[node.first_child + i].surface_error);
        return error;
    }

    // `error`: against the mesh that the branch's tiles are cut from.
    Status add_tile(std::uint32_t index, const Surface& surface, const metric::SurfaceError& error,
                    const codec::QuantizationGrid& grid) {
        std::vector<Tile>& tiles = branches_[index].tiles;
        Result<Tile> stored = store_tile(surface, error, grid, model_, tile_key(index, tiles.size()));
        if (!stored) return stored.error();
        Tile& tile = *stored;
        tile.node.error = error.max;
        if (!tiles_below(index).empty()) tile.node.error += source_error(index) + rounding_error(grid);
        for (const Tile* below : tiles_below(index)) {
            tile.node.error = std::max(tile.node.error, below->node.error);
            tile.node.box.add(below->node.box.min);
            tile.node.box.add(below->node.box.max);
        }
        tiles.push_back(*std::move(stored));
        return Nothing{};
    }

    // As a tile around it alone, without an error. `model`: its materials, images and origin.
    Result<Tile> store_tile(const Surface& surface, const metric::SurfaceError& error,
                            const codec::QuantizationGrid& grid, const mesh::Model& model, const std::string& key) {
        Result<codec::Encoded> encoded =
            encode_tile(surface, error, grid, model, texture::choose(model, textures_, level_needs(error)).images,
                        colors_ ? &*colors_ : nullptr);
        if (!encoded) return encoded.error();
        Result<store::StoredFile> file = store_.put_content(asset_id_, key, "glb", encoded->glb);
        if (!file) return file.error();
        Tile tile;
        const Box bounds = mesh::bounds(surface.mesh);
        tile.node.box = {bounds.min + model.origin, bounds.max + model.origin};
        tile.node.triangles = surface.mesh.triangles.size();
        tile.hash = file->hash;
        tile.bytes = file->bytes;
        return tile;
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
            if (!model_.instances.empty()) tree.matrices.push_back(tile.matrix);
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
    const mesh::Model shapes_model_;
    const std::vector<ShapeLevels>& shapes_;
    const texture::Textures& textures_;
    const std::function<bool(double)>& progress_;
    TrianglesByObject triangles_;
    bool may_paint_;
    std::optional<SceneColors> colors_;
    std::optional<TileBorders> borders_;  // of the leaves
    scene::Hierarchy hierarchy_;
    std::vector<Branch> branches_;                // of each node of the hierarchy
    std::vector<std::vector<Tile>> shape_tiles_;  // of each shape, the finest first
    std::vector<Place> places_;                   // of each tile of the tree
    std::atomic<bool> stopped_{false};
    std::mutex mutex_;
    double done_ = 0.0;  // nodes
    std::optional<Error> error_;
};

}  // namespace

Result<TileTree> make_tiles(store::Store& store, const std::string& asset_id, const SceneParts& scene,
                            const texture::Textures& textures, const std::function<bool(double)>& progress) {
    Result<TileTree> tree = TileMaker(store, asset_id, scene, textures, progress).make();
    if (!tree) return tree;
    if (Status valid = scene::validate(tree->nodes); !valid)
        return fail(ErrorCode::internal, "the tiles make no tree: " + valid.error().message);
    if (auto file = store.put_content(asset_id, tiles_key, "tiles", serialize(*tree)); !file) return file.error();
    return tree;
}

}  // namespace lodestream::bake
