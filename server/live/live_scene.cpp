#include "server/live/live_scene.h"

#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <limits>
#include <numeric>
#include <utility>

#include "server/bake/bake.h"

namespace lodestream::live {

namespace {

using scene::none;
using scene::Placement;

// Ids of tiles in a tileset: those that a bake has made begin at 0.
// Between the JSON of a stored node and the hash of what it shows.
constexpr char state_separator = '\n';
constexpr std::size_t hash_digits = 64;

// Of an added object's level among the scene's content.
std::string added_key(const std::string& hash) {
    return "added/" + hash;
}

constexpr std::uint64_t first_rest_id = 1ull << 32, first_object_id = 2ull << 32;

std::uint64_t microseconds_since_1970() {
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::microseconds>(now).count());
}

std::vector<std::uint32_t> tiles_of_objects(const bake::SceneSource& source) {
    std::vector<std::uint32_t> tiles(source.objects());
    for (std::uint32_t object = 0; object < tiles.size(); ++object) tiles[object] = source.tile(object);
    return tiles;
}

// Whether every object is shown by a tile that is there and the finest of its branch.
bool fits(const bake::SceneSource& source, const bake::TileTree& tiles) {
    for (std::uint32_t object = 0; object < source.objects(); ++object) {
        const std::uint32_t tile = source.tile(object);
        if (tile != bake::no_tile && (tile >= tiles.nodes.size() || tiles.nodes[tile].child_count > 0)) return false;
    }
    return true;
}

Error no_scene(const proto::Asset& asset, const char* why) {
    return fail(ErrorCode::conflict, "\"" + asset.name + "\" has no nodes that can be moved: " + why);
}

}  // namespace

Lists::Lists(std::size_t size, std::span<const std::uint32_t> owners) : first_(size + 1, 0) {
    for (const std::uint32_t owner : owners)
        if (owner != none) ++first_[owner + 1];
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    members_.resize(first_.back());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (std::uint32_t member = 0; member < owners.size(); ++member)
        if (owners[member] != none) members_[next[owners[member]]++] = member;
}

LiveScene::LiveScene(store::Store& store, std::string asset_id, std::string tiles_hash, bake::SceneSource source,
                     const bake::TileTree& tiles, std::shared_ptr<TransientFiles> files)
    : store_(store),
      asset_id_(std::move(asset_id)),
      tiles_hash_(std::move(tiles_hash)),
      source_(std::move(source)),
      files_(std::move(files)),
      tile_objects_(tiles.nodes.size(), tiles_of_objects(source_)),
      node_objects_(source_.model().graph.parents.size(), source_.model().graph.object_nodes),
      child_nodes_(source_.model().graph.parents.size(), source_.model().graph.parents) {
    for (std::size_t i = 0; i < tiles.nodes.size(); ++i) {
        const scene::LodNode& node = tiles.nodes[i];
        Tile& tile = tiles_.emplace_back();
        tile.content = {tiles.hashes[i], tiles.bytes[i], node.triangles, node.error, node.box, nullptr};
        if (!tiles.matrices.empty()) tile.content.matrix = tiles.matrices[i];
        tile.parent = node.parent;
        tile.first_child = node.first_child;
        tile.child_count = node.child_count;
    }
    // Objects below and the order of a walk, from the leaves up and from the root down.
    std::vector<std::uint32_t> below(tiles_.size(), 1);
    for (std::uint32_t i = static_cast<std::uint32_t>(tiles_.size()); i-- > 0;) {
        tiles_[i].visible_objects += static_cast<std::uint32_t>(tile_objects_.of(i).size());
        if (tiles_[i].parent == none) continue;
        tiles_[tiles_[i].parent].visible_objects += tiles_[i].visible_objects;
        below[tiles_[i].parent] += below[i];
    }
    tiles_.front().entered = 0;
    for (std::uint32_t i = 0; i < tiles_.size(); ++i) {
        std::uint32_t next = tiles_[i].entered + 1;
        tiles_[i].left = tiles_[i].entered + below[i];
        for (std::uint32_t child = tiles_[i].first_child; child < tiles_[i].first_child + tiles_[i].child_count;
             ++child) {
            tiles_[child].entered = next;
            next += below[child];
        }
        tiles_[i].is_rigid = tile_objects_.of(finest(i)).size() == 1;
    }
}

Result<std::shared_ptr<LiveScene>> LiveScene::open(store::Store& store, const proto::Asset& asset,
                                                   std::shared_ptr<TransientFiles> files) {
    if (!asset.hierarchy && asset.status == proto::AssetStatus::ready) return no_scene(asset, "it is one object");
    const Result<bake::TileTree> tiles = bake::load_tiles(store, asset);
    if (!tiles) return tiles.error();
    const Result<store::Store::Content> stored_tiles = store.content(asset.id, bake::tiles_key);
    if (!stored_tiles) return stored_tiles.error();
    Result<bake::SceneSource> source = bake::SceneSource::open(store, asset.id);
    if (!source && source.error().code == ErrorCode::not_found)
        return no_scene(asset, "it was baked by an older version; send it again");
    if (!source) return source.error();
    if (!fits(*source, *tiles)) return invalid_input("the stored objects are not those of the stored tiles");
    std::shared_ptr<LiveScene> scene(
        new LiveScene(store, asset.id, stored_tiles->file.hash, *std::move(source), *tiles, std::move(files)));
    if (Status restored = scene->restore(); !restored) return restored.error();
    return scene;
}

Status LiveScene::restore() {
    const Result<std::vector<store::Store::Node>> kept = store_.nodes(asset_id_);
    if (!kept) return kept.error();
    std::vector<proto::NodeChange> changes;
    std::map<std::uint32_t, std::string> hashes;
    for (const store::Store::Node& node : *kept) {
        const std::size_t end = std::min(node.state.find(state_separator), node.state.size());
        const auto change = proto::parse_node_changes(std::string_view(node.state).substr(0, end));
        if (!change) return fail(ErrorCode::internal, "the catalogue holds an unreadable node");
        changes.insert(changes.end(), change->begin(), change->end());
        if (end < node.state.size()) hashes[node.node] = node.state.substr(end + 1);
    }
    const std::lock_guard lock(mutex_);
    Result<Nodes> nodes = changed_nodes(changes);
    if (!nodes) return nodes.error();
    std::map<std::uint32_t, Content> added;
    for (auto& [number, node] : *nodes) {
        if (node.asset.empty()) continue;
        node.hash = hashes[number];
        const Result<store::Store::Content> stored = store_.content(asset_id_, added_key(node.hash));
        if (!stored) return stored.error();
        Result<Content> content = stored_content(node.hash, std::strtod(stored->record.c_str(), nullptr));
        if (!content) return content.error();
        added[number] = *std::move(content);
    }
    const Result<Placements> objects = objects_below(*nodes, added);
    if (!objects) return objects.error();
    install(*nodes, std::move(added), *objects);
    if (!kept->empty()) changed_now();
    return Nothing{};
}

std::uint32_t LiveScene::finest(std::uint32_t tile) const {
    while (tiles_[tile].child_count == 1) tile = tiles_[tile].first_child;
    return tile;
}

std::vector<std::uint32_t> LiveScene::levels_above(std::uint32_t finest) const {
    std::vector<std::uint32_t> levels;
    if (tiles_[finest].child_count > 0) levels.push_back(finest);
    for (std::uint32_t tile = tiles_[finest].parent; tile != none && tiles_[tile].child_count == 1;
         tile = tiles_[tile].parent)
        levels.push_back(tile);
    return levels;
}

bool LiveScene::is_below(std::uint32_t object, const Tile& tile) const {
    const std::uint32_t own = tile_of(object);
    return own != bake::no_tile && tiles_[own].entered >= tile.entered && tiles_[own].entered < tile.left;
}

void LiveScene::changed_now() {
    revision_ = std::max(revision_ + 1, microseconds_since_1970());
}

LiveScene::PlacementPointer LiveScene::pointer(std::uint32_t object) const {
    const auto found = moved_.find(object);
    return found == moved_.end() ? nullptr : found->second.pointer;
}

Placement LiveScene::placement(std::uint32_t object) const {
    const PlacementPointer now = pointer(object);
    return now ? *now : as_source(object);
}

double LiveScene::off(const Shown& shown, std::uint32_t object) const {
    const auto found = shown.find(object);
    const Placement as_shown = found == shown.end() || !found->second ? as_source(object) : *found->second;
    return scene::displacement(box_of(object), as_shown, placement(object));
}

std::set<std::uint32_t> LiveScene::displaced(std::uint32_t finest) const {
    std::set<std::uint32_t> objects;
    const Tile& tile = tiles_[finest];
    for (const std::uint32_t object : tile_objects_.of(finest))
        if (!tile.is_rigid && off(tile.shown, object) > 0.0) objects.insert(object);
    for (const std::uint32_t object : added_beside(finest))
        if (off(tile.shown, object) > 0.0) objects.insert(object);
    return objects;
}

std::span<const std::uint32_t> LiveScene::added_beside(std::uint32_t tile) const {
    const auto found = added_of_tile_.find(tile);
    return found == added_of_tile_.end() ? std::span<const std::uint32_t>{} : found->second;
}

bool LiveScene::has_added(std::uint32_t finest) const {
    return std::ranges::any_of(added_beside(finest), [&](std::uint32_t object) { return placement(object).visible; });
}

std::uint32_t LiveScene::parent_of(std::uint32_t node, const Nodes& changed) const {
    if (node < source_nodes()) return source_.model().graph.parents[node];
    const auto found = changed.find(node);
    return found != changed.end() ? *found->second.parent : new_parents_[node - source_nodes()];
}

Result<LiveScene::Nodes> LiveScene::changed_nodes(std::span<const proto::NodeChange> changes) const {
    Nodes changed;
    auto count = static_cast<std::uint32_t>(node_count());
    const auto no_node = [&](std::uint32_t node) {
        return fail(ErrorCode::not_found,
                    "there is no node " + std::to_string(node) + ", the scene has " + std::to_string(count));
    };
    for (const proto::NodeChange& change : changes) {
        std::uint32_t number = change.node;
        if (change.parent) {
            if (number != proto::next_node && number != count)
                return fail(ErrorCode::conflict,
                            "a new node would be " + std::to_string(count) + ", not " + std::to_string(number));
            if (*change.parent >= count) return no_node(*change.parent);
            if (count >= source_nodes() + max_added_nodes)
                return fail(ErrorCode::limit_exceeded,
                            "the scene would have more than " + std::to_string(max_added_nodes) + " added nodes");
            number = count++;
        }
        if (number >= count) return no_node(number);
        const auto before = nodes_.find(number);
        Node node = before == nodes_.end() ? Node{} : before->second;
        node.placement.matrix = change.matrix.value_or(node.placement.matrix);
        node.placement.visible = change.visible.value_or(node.placement.visible);
        node.asset = change.asset.value_or(node.asset);
        if (change.parent) node.parent = change.parent;
        changed[number] = std::move(node);
    }
    return changed;
}

// Of all objects at and below changed nodes, where these changes put them.
Result<LiveScene::Placements> LiveScene::objects_below(const Nodes& changed,
                                                       const std::map<std::uint32_t, Content>& added) const {
    const auto own = [&](std::uint32_t node) {
        if (const auto found = changed.find(node); found != changed.end()) return found->second;
        const auto found = nodes_.find(node);
        return found == nodes_.end() ? Node{} : found->second;
    };
    Placements objects;
    const auto place_objects_of = [&](std::uint32_t node, const Placement& now) {
        const bool has_asset = !own(node).asset.empty();
        if (node < source_nodes())
            for (const std::uint32_t object : node_objects_.of(node))
                objects[object] = {now.matrix, now.visible && !has_asset};
        const auto next = added.find(node);
        if (const auto before = added_of_node_.find(node); before != added_of_node_.end())
            objects[before->second] = has_asset && next == added.end() && now.visible ? now : as_source(before->second);
        if (next == added.end()) return;
        const auto place_in = static_cast<std::size_t>(std::distance(added.begin(), next));
        const auto object = static_cast<std::uint32_t>(source_.objects() + added_.size() + place_in);
        objects[object] = now.visible ? now : as_source(object);
    };
    for (const auto& [top, node] : changed) {
        Placement above;
        for (std::uint32_t up = parent_of(top, changed); up != mesh::no_parent; up = parent_of(up, changed))
            above = scene::combined(own(up).placement, above);
        std::vector<std::pair<std::uint32_t, Placement>> open{{top, scene::combined(above, node.placement)}};
        while (!open.empty()) {
            const auto [below, now] = open.back();
            open.pop_back();
            if (Status valid = scene::validate(now); !valid)
                return invalid_input("node " + std::to_string(below) + ": its place, with the nodes above, " +
                                     valid.error().message);
            place_objects_of(below, now);
            if (objects.size() > max_moved_objects)
                return fail(ErrorCode::limit_exceeded,
                            "it moves more than " + std::to_string(max_moved_objects) + " objects");
            const auto go_on = [&, place = now](std::uint32_t child) {
                open.push_back({child, scene::combined(place, own(child).placement)});
            };
            if (below < source_nodes()) std::ranges::for_each(child_nodes_.of(below), go_on);
            if (const auto more = new_children_.find(below); more != new_children_.end())
                std::ranges::for_each(more->second, go_on);
        }
    }
    return objects;
}

Status LiveScene::check(const Placements& objects) const {
    std::size_t away = away_;
    std::int64_t visible = tiles_.front().visible_objects;
    const auto is_new = [&](std::uint32_t object) { return object >= source_.objects() + added_.size(); };
    for (const auto& [object, now] : objects) {
        const Placement before = is_new(object) ? as_source(object) : placement(object);
        away += (now == as_source(object) ? 0 : 1);
        away -= (before == as_source(object) ? 0 : 1);
        if (is_new(object) || tile_of(object) != bake::no_tile) visible += int{now.visible} - int{before.visible};
        if (is_new(object) && object - source_.objects() >= max_added_objects)
            return fail(ErrorCode::limit_exceeded, "more than " + std::to_string(max_added_objects) +
                                                       " objects were added since the scene was opened");
    }
    if (away > max_moved_objects)
        return fail(ErrorCode::limit_exceeded, "more than " + std::to_string(max_moved_objects) +
                                                   " objects of the scene would not be where its source has them");
    if (visible <= 0) return fail(ErrorCode::conflict, "nothing of the scene would be left to see");
    return Nothing{};
}

void LiveScene::place(std::uint32_t object, const Placement& now) {
    const Placement before = placement(object);
    if (before == now) return;
    away_ += now == as_source(object) ? 0 : 1;
    away_ -= before == as_source(object) ? 0 : 1;
    Moved& moved = moved_[object];
    moved.pointer = now == as_source(object) ? nullptr : std::make_shared<const Placement>(now);
    moved.at = Clock::now();
    const std::uint32_t own = tile_of(object);
    if (own == bake::no_tile) return;
    for (std::uint32_t i = own; i != none; i = tiles_[i].parent) {
        Tile& tile = tiles_[i];
        if (before.visible && !now.visible) --tile.visible_objects;
        if (!before.visible && now.visible) ++tile.visible_objects;
        if (tile.is_rigid) continue;
        tile.stale = std::max(tile.stale, off(tile.shown, object));
        if (i != own) untrue_.insert(finest(i));
    }
    const auto split = splits_.find(own);
    const bool has_tile = split != splits_.end() && split->second.out.contains(object);
    if (!tiles_[own].is_rigid && !has_tile) unsplit_.insert(own);
}

// Of tiles as near as each other one of several objects.
std::uint32_t LiveScene::nearest_finest(const Box& box) const {
    std::uint32_t nearest = none;
    std::pair<double, bool> least{std::numeric_limits<double>::infinity(), true};
    for (std::uint32_t i = 0; i < tiles_.size(); ++i) {
        if (tiles_[i].child_count > 0) continue;
        const Box& own = tiles_[i].content.box;
        const Vec3d gap = glm::max(glm::max(own.min - box.max, box.min - own.max), Vec3d(0.0));
        const std::pair<double, bool> cost{length(gap), tiles_[i].is_rigid};
        if (nearest != none && !(cost < least)) continue;
        nearest = i;
        least = cost;
    }
    return nearest;
}

void LiveScene::make_shared(std::uint32_t leaf) {
    if (!tiles_[leaf].is_rigid) return;
    const std::uint32_t object = tile_objects_.of(leaf).front();
    for (std::uint32_t i = leaf; i != none && (i == leaf || tiles_[i].child_count == 1); i = tiles_[i].parent) {
        tiles_[i].is_rigid = false;
        tiles_[i].stale = off(tiles_[i].shown, object);
        if (i != leaf && tiles_[i].stale > 0.0) untrue_.insert(leaf);
    }
    if (tiles_[leaf].stale > 0.0) unsplit_.insert(leaf);
}

void LiveScene::add_object(std::uint32_t node, Content content) {
    const auto object = static_cast<std::uint32_t>(source_.objects() + added_.size());
    const std::uint32_t tile = nearest_finest(content.box);
    make_shared(tile);
    added_.push_back({node, tile, content.box});
    added_of_node_[node] = object;
    added_of_tile_[tile].push_back(object);
    moved_[object].own = std::move(content);
}

void LiveScene::install(const Nodes& changed, std::map<std::uint32_t, Content> added, const Placements& objects) {
    for (auto& [node, content] : added) add_object(node, std::move(content));
    for (const auto& [number, node] : changed) {
        if (number >= node_count()) {
            new_children_[*node.parent].push_back(number);
            new_parents_.push_back(*node.parent);
        }
        nodes_[number] = node;
    }
    for (const auto& [object, placement] : objects) place(object, placement);
}

Result<Content> LiveScene::stored_content(const std::string& hash, double error) const {
    const Result<StoredLevel> stored = read_level(store_, hash);
    if (!stored) return stored.error();
    return content_of(stored->file, stored->glb, error);
}

// Its finest level, kept with this scene from then on.
Result<Content> LiveScene::content_of_asset(const std::string& name) {
    const Result<proto::Asset> asset = store_.asset(name);
    if (!asset) return asset.error();
    if (asset->status != proto::AssetStatus::ready || asset->levels.empty())
        return fail(ErrorCode::conflict,
                    "\"" + name + "\" cannot be shown by a node: it is not ready or has no triangles");
    const proto::Level& level = asset->levels.front();
    if (level.triangles > max_added_triangles)
        return fail(ErrorCode::limit_exceeded, "\"" + name + "\" has " + std::to_string(level.triangles) +
                                                   " triangles, more than the " + std::to_string(max_added_triangles) +
                                                   " that a node may show");
    const std::size_t prefix = bake::content_url("").size() - std::string_view(".glb").size();
    const std::string hash = level.url.substr(std::min(prefix, level.url.size()), hash_digits);
    const Result<StoredLevel> stored = read_level(store_, hash);
    if (!stored) return stored.error();
    Result<Content> content = content_of(stored->file, stored->glb, level.max_error);
    if (!content) return content.error();
    auto kept = store_.put_content(asset_id_, added_key(hash), "glb", stored->glb, std::to_string(level.max_error));
    if (!kept) return kept.error();
    return content;
}

Result<proto::NodesChanged> LiveScene::change(std::span<const proto::NodeChange> changes) {
    const std::lock_guard one_at_a_time(changing_);
    Nodes nodes, before;
    std::size_t first_new = 0;
    {
        const std::lock_guard lock(mutex_);
        Result<Nodes> changed = changed_nodes(changes);
        if (!changed) return changed.error();
        nodes = *std::move(changed);
        before = nodes_;
        first_new = node_count();
    }
    std::map<std::uint32_t, Content> added;
    for (auto& [number, node] : nodes) {
        if (node.asset.empty() || (before.contains(number) && before.at(number).asset == node.asset)) continue;
        Result<Content> content = content_of_asset(node.asset);
        if (!content) return content.error();
        node.hash = content->hash;
        added[number] = *std::move(content);
    }
    Placements objects;
    {
        const std::lock_guard lock(mutex_);
        Result<Placements> below = objects_below(nodes, added);
        if (!below) return below.error();
        objects = *std::move(below);
        if (Status fits = check(objects); !fits) return fits.error();
    }
    std::vector<store::Store::Node> kept;
    proto::NodesChanged answer;
    for (const auto& [number, node] : nodes) {
        proto::NodeChange change{number, node.placement.matrix, node.placement.visible, std::nullopt, node.parent};
        if (!node.asset.empty()) change.asset = node.asset;
        std::string state = proto::to_json(std::vector{change});
        if (!node.asset.empty()) state += state_separator + node.hash;
        kept.push_back({number, std::move(state)});
        if (number >= first_new) answer.added.push_back(number);
    }
    if (Status stored = store_.put_nodes(asset_id_, kept); !stored) return stored.error();
    const std::lock_guard lock(mutex_);
    install(nodes, std::move(added), objects);
    changed_now();
    answer.revision = revision_;
    answer.moved_objects = away_;
    return answer;
}

bool LiveScene::is_current() const {
    const Result<store::Store::Content> tiles = store_.content(asset_id_, bake::tiles_key);
    return tiles && tiles->file.hash == tiles_hash_;
}

std::uint64_t LiveScene::revision() const {
    const std::lock_guard lock(mutex_);
    return revision_;
}

std::size_t LiveScene::moved_objects() const {
    const std::lock_guard lock(mutex_);
    return away_;
}

bool LiveScene::is_behind() const {
    const std::lock_guard lock(mutex_);
    return !unsplit_.empty();
}

proto::Tileset LiveScene::tileset() const {
    const std::lock_guard lock(mutex_);
    proto::Tileset tileset;
    tileset.revision = revision_;
    const auto add = [&](std::uint32_t parent, const Content& content, const Placement& placement, double stale,
                         std::uint32_t node, std::uint64_t id) {
        scene::LodNode& added = tileset.nodes.emplace_back();
        added.box = scene::placed(content.box, placement.matrix);
        added.error = content.error * scene::largest_scale(placement.matrix) + stale;
        added.triangles = content.triangles;
        added.parent = parent;
        tileset.uris.push_back(bake::content_url(content.hash));
        tileset.bytes.push_back(content.bytes);
        tileset.matrices.push_back(placement.matrix * content.matrix);
        tileset.scene_nodes.push_back(node);
        tileset.ids.push_back(id);
    };
    std::vector<std::uint32_t> tiles;  // of each node of the tileset, or none
    const auto add_tile = [&](std::uint32_t parent, std::uint32_t i) {
        const Tile& tile = tiles_[i];
        const std::uint32_t object = tile.is_rigid ? tile_objects_.of(finest(i)).front() : none;
        add(parent, tile.content, tile.is_rigid ? placement(object) : Placement{}, tile.stale,
            tile.is_rigid ? node_of(object) : proto::no_scene_node, i);
        tiles.push_back(i);
        if (tile.stale > 0.0 && tile.child_count == 0)
            for (const std::uint32_t away : displaced(i)) {
                const Placement now = placement(away);
                if (!now.visible) continue;
                const Box box = scene::placed(box_of(away), now.matrix);
                tileset.nodes.back().box.add(box.min);
                tileset.nodes.back().box.add(box.max);
            }
    };
    const auto add_split = [&](std::uint32_t parent, std::uint32_t i, const Split& split) {
        double stale = 0.0;
        for (const auto& objects : {tile_objects_.of(i), added_beside(i)})
            for (const std::uint32_t object : objects)
                if (!split.out.contains(object)) stale = std::max(stale, off(tiles_[i].shown, object));
        if (split.rest.triangles > 0) add(parent, split.rest, {}, stale, proto::no_scene_node, first_rest_id + i);
        for (const std::uint32_t object : split.out)
            if (const Placement now = placement(object); now.visible)
                add(parent, moved_.at(object).own, now, 0.0, node_of(object), first_object_id + object);
        tiles.resize(tileset.nodes.size(), none);
    };
    add_tile(none, 0);
    for (std::uint32_t node = 0; node < tileset.nodes.size(); ++node) {
        if (tiles[node] == none) continue;
        const auto first = static_cast<std::uint32_t>(tileset.nodes.size());
        const Tile& tile = tiles_[tiles[node]];
        for (std::uint32_t child = tile.first_child; child < tile.first_child + tile.child_count; ++child)
            if (tiles_[child].visible_objects > 0) add_tile(node, child);
        if (const auto split = splits_.find(tiles[node]); split != splits_.end())
            add_split(node, tiles[node], split->second);
        tileset.nodes[node].child_count = static_cast<std::uint32_t>(tileset.nodes.size()) - first;
        tileset.nodes[node].first_child = tileset.nodes[node].child_count > 0 ? first : 0;
    }
    scene::keep_the_laws(tileset.nodes);
    return tileset;
}

proto::SceneNodes LiveScene::nodes(std::uint32_t first, std::size_t count) const {
    const std::lock_guard lock(mutex_);
    proto::SceneNodes out{revision_, node_count(), {}};
    const std::size_t end = std::min(node_count(), first + std::min(count, max_listed_nodes));
    for (std::uint32_t i = first; i < end; ++i) {
        proto::SceneNode& node = out.nodes.emplace_back();
        node.node = i;
        if (const std::uint32_t parent = parent_of(i, {}); parent != mesh::no_parent) node.parent = parent;
        std::vector<std::uint32_t> objects;
        if (const auto changed = nodes_.find(i); changed != nodes_.end()) {
            node.placement = changed->second.placement;
            node.asset = changed->second.asset;
        }
        if (!node.asset.empty())
            objects = {added_of_node_.at(i)};
        else if (i < source_nodes())
            objects.assign(node_objects_.of(i).begin(), node_objects_.of(i).end());
        node.objects = objects.size();
        for (const std::uint32_t object : objects) {
            const Box box = scene::placed(box_of(object), placement(object).matrix);
            if (box.empty()) continue;
            node.bounds.add(box.min);
            node.bounds.add(box.max);
        }
    }
    return out;
}

void LiveScene::installed(std::uint32_t i, Content content, Shown shown) {
    Tile& tile = tiles_[i];
    tile.content = std::move(content);
    tile.shown = std::move(shown);
    ++tile.made;
    tile.stale = 0.0;
    for (const auto& [object, moved] : moved_)
        if (is_below(object, tile)) tile.stale = std::max(tile.stale, off(tile.shown, object));
    changed_now();
}

bool LiveScene::make_rest() {
    std::unique_lock lock(mutex_);
    if (unsplit_.empty()) return false;
    const auto next = unsplit_.lower_bound(next_unsplit_);
    const std::uint32_t leaf = next == unsplit_.end() ? *unsplit_.begin() : *next;
    next_unsplit_ = leaf + 1;
    unsplit_.erase(leaf);
    const Tile& tile = tiles_[leaf];
    const std::uint32_t made = tile.made;
    std::set<std::uint32_t> out = displaced(leaf);
    if (const auto split = splits_.find(leaf); split != splits_.end())
        out.insert(split->second.out.begin(), split->second.out.end());
    std::vector<PlacedObject> rest;
    for (const std::uint32_t object : tile_objects_.of(leaf)) {
        if (out.contains(object)) continue;
        const auto shown = tile.shown.find(object);
        rest.push_back({object, shown == tile.shown.end() || !shown->second ? Placement{} : *shown->second});
    }
    std::vector<std::uint32_t> lacking;
    for (const std::uint32_t object : out)
        if (moved_.at(object).own.triangles == 0) lacking.push_back(object);
    lock.unlock();

    Result<ObjectsContent> rest_content = make_objects_content(*files_, source_, rest);
    std::map<std::uint32_t, Content> own;
    for (const std::uint32_t object : lacking) {
        if (!rest_content) break;
        Result<ObjectsContent> content = make_objects_content(*files_, source_, std::vector{PlacedObject{object, {}}});
        if (!content) rest_content = content.error();
        if (content) own[object] = std::move(content->content);
    }
    lock.lock();
    if (!rest_content) return true;
    if (tile.made != made) {
        unsplit_.insert(leaf);
        return true;
    }
    for (auto& [object, content] : own) moved_.at(object).own = std::move(content);
    Split& split = splits_[leaf];
    split.out = std::move(out);
    split.rest = std::move(rest_content->content);
    const std::set<std::uint32_t> away = displaced(leaf);
    if (!std::includes(split.out.begin(), split.out.end(), away.begin(), away.end())) unsplit_.insert(leaf);
    changed_now();
    return true;
}

// What a finest tile of several objects shows, at its truest.
void LiveScene::gather_finest(std::uint32_t i, std::vector<PlacedContent>& below, Shown& shown) const {
    const Tile& tile = tiles_[i];
    shown.insert(tile.shown.begin(), tile.shown.end());
    const auto split = splits_.find(i);
    if (split == splits_.end()) {
        below.push_back({tile.content, {}});
        return;
    }
    below.push_back({split->second.rest, {}});
    for (const std::uint32_t object : split->second.out) {
        shown[object] = pointer(object);
        below.push_back({moved_.at(object).own, placement(object)});
    }
}

void LiveScene::gather_below(std::uint32_t i, std::vector<PlacedContent>& below, Shown& shown) const {
    if (tiles_[i].child_count == 0) return gather_finest(i, below, shown);
    for (std::uint32_t child = tiles_[i].first_child; child < tiles_[i].first_child + tiles_[i].child_count; ++child) {
        const Tile& tile = tiles_[child];
        if (tile.visible_objects == 0) {
            for (const auto& [object, moved] : moved_)
                if (is_below(object, tile)) shown[object] = moved.pointer;
        } else if (tile.is_rigid) {
            const std::uint32_t object = tile_objects_.of(finest(child)).front();
            shown[object] = pointer(object);
            below.push_back({tile.content, placement(object)});
        } else if (tile.child_count == 0) {
            gather_finest(child, below, shown);
        } else {
            shown.insert(tile.shown.begin(), tile.shown.end());
            below.push_back({tile.content, {}});
        }
    }
}

// Finest tiles that may be whole again first, then those above others, the deepest first; the last one is the first.
std::vector<std::uint32_t> LiveScene::next_round() const {
    std::vector<std::uint32_t> round(untrue_.begin(), untrue_.end());
    const Clock::time_point now = Clock::now();
    for (const auto& [leaf, split] : splits_) {
        const bool rests = std::all_of(split.out.begin(), split.out.end(),
                                       [&](std::uint32_t object) { return moved_.at(object).at + rest_time <= now; });
        if (rests && split.is_exact && !has_added(leaf) && !unsplit_.contains(leaf) && tiles_[leaf].visible_objects > 0)
            round.push_back(leaf);
    }
    return round;
}

bool LiveScene::make_above(const std::function<bool()>& goes_on) {
    std::uint32_t next = none;
    bool is_whole = false;
    {
        const std::lock_guard lock(mutex_);
        if (round_.empty()) round_ = next_round();
        if (round_.empty()) return false;
        next = round_.back();
        round_.pop_back();
        is_whole = splits_.contains(next) && !has_added(next);
    }
    if (is_whole) make_whole(next);
    make_levels(next, goes_on);
    return true;
}

void LiveScene::make_whole(std::uint32_t leaf) {
    std::unique_lock lock(mutex_);
    std::vector<PlacedObject> objects;
    Shown shown;
    for (const std::uint32_t object : tile_objects_.of(leaf)) {
        objects.push_back({object, placement(object)});
        if (const PlacementPointer now = pointer(object)) shown[object] = now;
    }
    lock.unlock();
    Result<ObjectsContent> content = make_objects_content(*files_, source_, objects);
    lock.lock();
    Split& split = splits_.at(leaf);
    if (!content || !content->is_exact || content->content.triangles == 0) {
        split.is_exact = false;
        return;
    }
    for (const std::uint32_t object : split.out)
        if (!is_added(object)) moved_.at(object).own = {};
    splits_.erase(leaf);
    installed(leaf, std::move(content->content), std::move(shown));
    if (tiles_[leaf].stale > 0.0) unsplit_.insert(leaf);
}

void LiveScene::make_levels(std::uint32_t lowest, const std::function<bool()>& goes_on) {
    std::vector<PlacedContent> below;
    Shown shown;
    std::vector<std::uint32_t> levels;
    {
        const std::lock_guard lock(mutex_);
        if (untrue_.erase(lowest) == 0) return;
        levels = levels_above(lowest);
        if (levels.empty() || tiles_[lowest].visible_objects == 0) return;
        gather_below(lowest, below, shown);
    }
    Result<std::vector<Content>> contents =
        make_levels_above(*files_, store_, source_.model(), below, levels.size(), levels.back() == 0, goes_on);
    const std::lock_guard lock(mutex_);
    if (!contents) return;
    for (std::size_t k = 0; k < levels.size(); ++k) installed(levels[k], std::move((*contents)[k]), shown);
    if (tiles_[levels.front()].stale > 0.0) untrue_.insert(lowest);
}

}  // namespace lodestream::live
