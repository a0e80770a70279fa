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

#include "common/codec/level_codec.h"
#include "common/mesh/operations.h"
#include "common/metric/surface_distance.h"
#include "common/scene/fit_colors.h"
#include "common/scene/hierarchy.h"
#include "common/scene/surroundings.h"
#include "common/simplify/history.h"
#include "server/bake/bake.h"
#include "server/bake/executor.h"
#include "server/bake/textures.h"

namespace lodestream::bake {

namespace {

constexpr std::uint32_t rough_cells = 48;
constexpr double wrapped_ratio = 8.0;  // triangles of a surface wrapped around to those of the finest tile of it
constexpr const char* painted_name = "painted";
constexpr std::size_t samples_per_triangle = 4;  // beside the corners: tiles are of small triangles of about one size

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

std::size_t samples_of(const mesh::Mesh& mesh) {
    return std::min(metric::default_samples, samples_per_triangle * mesh.triangles.size());
}

bool can_be_painted(const mesh::Model& model) {
    return std::all_of(model.materials.begin(), model.materials.end(), [](const mesh::Material& material) {
        return material.alpha_mode == mesh::AlphaMode::opaque && !mesh::has_texture(material);
    });
}

struct Tile {
    scene::LodNode node;  // without its place in the tree
    std::string hash;
    std::uint64_t bytes = 0;
};

// What a node of the hierarchy has become: tiles that follow each other from the finest to the coarsest, and the mesh
// of that one until the tile above is made. A painted mesh has its materials as colours of its vertices.
struct Branch {
    std::vector<Tile> tiles;
    mesh::Mesh mesh;
    bool is_painted = false;
};

// One of the surfaces that a branch's tiles may be cut from.
struct Source {
    mesh::Mesh mesh;
    bool is_painted = false;
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
          can_paint_(can_be_painted(model)) {
        content_.materials = model.materials;
        content_.origin = model.origin;
        if (can_paint_)
            content_.materials.emplace_back().name = painted_name;
        else
            content_.images = model.images;
        scene::HierarchyOptions options;
        options.leaf_triangles = tile_triangles;
        options.max_children = max_tile_children;
        hierarchy_ = scene::build_hierarchy(describe_objects(model, triangles_), model.graph.parents, options);
        branches_.resize(hierarchy_.nodes.size());
    }

    Result<TileTree> make() {
        for (const std::vector<std::uint32_t>& wave : waves()) {
            const simplify::Executor executor = all_cores(), none;
            executor(wave.size(), [&](std::size_t i) { make_branch(wave[i], wave.size() == 1 ? executor : none); });
            if (error_) return *error_;
        }
        return tree();
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
        if (Status added = add_tile(index, source, {}); !added) return added;

        std::vector<std::uint64_t> counts;
        add_chain(counts, source.triangles.size(), index == 0 ? coarsest_tile : tile_triangles);
        branches_[index].mesh = source;
        if (counts.empty()) return Nothing{};
        const metric::SurfaceIndex original(source, samples_of(source));
        std::vector<Source> sources;
        sources.push_back({std::move(source), false});
        return add_levels(index, original, {}, std::move(sources), counts, executor);
    }

    // Tiles are cut from what is seen of the tiles below, or from the surface wrapped around it.
    Status make_inner(std::uint32_t index, const simplify::Executor& executor) {
        Source below = joined_children(index);
        const auto most = static_cast<std::uint64_t>(tile_ratio * static_cast<double>(below.mesh.triangles.size()));
        std::vector<std::uint64_t> counts{std::clamp<std::uint64_t>(most, 1, tile_triangles)};
        if (index == 0) add_chain(counts, counts.back(), coarsest_tile);

        const mesh::Mesh painted_below = can_paint_ && !below.is_painted ? painted(below.mesh) : below.mesh;
        const scene::Surroundings around(painted_below, cells_for(painted_below, counts.front()));
        std::vector<Source> sources;
        sources.push_back({mesh::compact(mesh::part(below.mesh, around.visible_triangles())), below.is_painted});
        mesh::Mesh colored;
        if (can_paint_) {
            colored = mesh::part(painted_below, around.visible_triangles());
            mesh::Mesh wrapped = around.wrapped();
            wrapped.triangle_materials.assign(wrapped.triangles.size(), painted_material());
            if (!wrapped.triangles.empty()) sources.push_back({std::move(wrapped), true});
        }
        below = {};
        metric::SurfaceIndex original(sources.front().mesh, samples_of(sources.front().mesh));
        original.keep_samples([&](const Vec3f& position) { return around.sees(position); });
        return add_levels(index, original, colored, std::move(sources), counts, executor);
    }

    Source joined_children(std::uint32_t index) {
        const scene::HierarchyNode& node = hierarchy_.nodes[index];
        const std::span children = std::span(branches_).subspan(node.first_child, node.child_count);
        Source joined;
        joined.is_painted =
            std::any_of(children.begin(), children.end(), [](const Branch& child) { return child.is_painted; });
        for (Branch& child : children) {
            const mesh::Mesh mesh = std::exchange(child.mesh, {});
            mesh::append(joined.mesh, joined.is_painted && !child.is_painted ? painted(mesh) : mesh);
        }
        joined.mesh = mesh::compact(mesh::part(joined.mesh, mesh::distinct_triangles(joined.mesh)));
        return joined;
    }

    std::uint32_t painted_material() const { return static_cast<std::uint32_t>(model_.materials.size()); }

    mesh::Mesh painted(const mesh::Mesh& mesh) const {
        mesh::Mesh out = mesh::compact(mesh);  // no vertex has two materials
        std::vector<Rgba8> colors(out.positions.size(), Rgba8(255));
        for (std::size_t t = 0; t < out.triangles.size(); ++t) {
            const Vec4f color = model_.materials[mesh::material_of(out, t)].base_color;
            for (const std::uint32_t v : out.triangles[t]) {
                const Vec4f own = out.colors.empty() ? Vec4f(1.0f) : Vec4f(out.colors[v]) / 255.0f;
                colors[v] = Rgba8(clamp(color * own, Vec4f(0.0f), Vec4f(1.0f)) * 255.0f + 0.5f);
            }
        }
        out.colors = std::move(colors);
        out.texture_coordinates.clear();
        out.triangle_materials.assign(out.triangles.size(), painted_material());
        return out;
    }

    // How fine the surface wrapped around is to be, for a tile of so many triangles.
    static std::uint32_t cells_for(const mesh::Mesh& mesh, std::uint64_t triangles) {
        const double faces = static_cast<double>(scene::Surroundings(mesh, rough_cells).faces());
        const double wanted = wrapped_ratio * static_cast<double>(triangles) / 2.0;
        return static_cast<std::uint32_t>(
            std::clamp<double>(rough_cells * std::sqrt(wanted / faces), scene::min_cells, scene::max_cells));
    }

    // Counts that fall from one of `triangles` until they are not above `end`.
    static void add_chain(std::vector<std::uint64_t>& counts, std::uint64_t triangles, std::uint64_t end) {
        while (triangles > end) {
            triangles = std::max(end, static_cast<std::uint64_t>(chain_ratio * static_cast<double>(triangles)));
            counts.push_back(triangles);
        }
    }

    // Adds a tile of each of these counts, each on top of the one before, from the source that shows that count best.
    // `original`: of the first source; `colored`: the first source painted, where any is painted.
    Status add_levels(std::uint32_t index, const metric::SurfaceIndex& original, const mesh::Mesh& colored,
                      std::vector<Source> sources, const std::vector<std::uint64_t>& counts,
                      const simplify::Executor& executor) {
        const mesh::Mesh seen = sources.front().mesh;
        std::vector<simplify::History> histories;
        for (Source& source : sources) {
            simplify::RecordOptions options;
            options.executor = executor;
            options.progress = [&](double) { return report(0.0); };
            Result<simplify::History> history = simplify::record_history(std::move(source.mesh), options);
            if (!history) return history.error();
            histories.push_back(*std::move(history));
        }
        Branch& branch = branches_[index];
        for (const std::uint64_t count : counts) {
            mesh::Mesh best;
            metric::SurfaceError least;
            bool is_painted = false;
            for (std::size_t i = 0; i < histories.size(); ++i) {
                mesh::Mesh level = simplify::cut(histories[i], count);
                const metric::SurfaceError error = metric::measure(original, seen, level);
                if (i > 0 && !(error.rms < least.rms)) continue;
                best = std::move(level);
                least = error;
                is_painted = sources[i].is_painted;
            }
            const bool is_coarser = branch.tiles.empty() || best.triangles.size() < branch.tiles.back().node.triangles;
            if (!is_coarser) continue;
            if (is_painted) best.colors = scene::fit_colors(best, colored);
            if (Status added = add_tile(index, best, least); !added) return added;
            branch.mesh = std::move(best);
            branch.is_painted = is_painted;
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
    Status add_tile(std::uint32_t index, const mesh::Mesh& mesh, metric::SurfaceError error) {
        const Box bounds = mesh::bounds(mesh);
        const codec::QuantizationGrid grid = codec::choose_window(bounds, error.rms, mean_edge_length(mesh));
        const bool is_coarser = !tiles_below(index).empty();
        if (is_coarser) error.max += source_error(index) + 0.5 * std::sqrt(3.0) * grid.step();
        Tile tile;
        tile.node.triangles = mesh.triangles.size();
        tile.node.error = error.max;
        tile.node.box = {bounds.min + model_.origin, bounds.max + model_.origin};
        for (const Tile* below : tiles_below(index)) {
            tile.node.error = std::max(tile.node.error, below->node.error);
            tile.node.box.add(below->node.box.min);
            tile.node.box.add(below->node.box.max);
        }

        codec::EncodeOptions options;
        options.grid = grid;
        options.images = texture::choose(content_, textures_, level_needs(error)).images;
        const std::vector<std::uint8_t> all_gouraud(mesh.triangles.size(), 1);
        Result<codec::Encoded> encoded = codec::encode_level(content_, mesh, all_gouraud, options);
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

    // Root first, children side by side and after their parent.
    TileTree tree() const {
        struct Place {
            std::uint32_t branch, tile;
        };
        std::vector<Place> places;
        TileTree tree;
        const auto add = [&](Place place, std::uint32_t parent) {
            const Tile& tile = branches_[place.branch].tiles[place.tile];
            places.push_back(place);
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
            const Place place = places[i];
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
    bool can_paint_;
    mesh::Model content_;  // the materials and images that tiles have
    scene::Hierarchy hierarchy_;
    std::vector<Branch> branches_;  // of each node of the hierarchy
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
