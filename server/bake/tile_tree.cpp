// The stored form of a tile tree: magic "LODTILE2", then the fields below in order, as stored_form.h says.
// "LODTILE1" is the same without matrices, and still read.
#include "server/bake/tile_tree.h"

#include <algorithm>

#include "common/scene/placement.h"
#include "server/bake/stored_form.h"

namespace lodestream::bake {

namespace {

constexpr std::string_view magic = "LODTILE2", older_magic = "LODTILE1";
constexpr std::size_t hash_digits = 64;
constexpr std::string_view content_prefix = "/v1/content/";

template <class Stream, class Node>
void describe_node(Stream& stream, Node& node) {
    stream(node.box);
    stream(node.error);
    stream(node.triangles);
    stream(node.parent);
    stream(node.first_child);
    stream(node.child_count);
}

bool is_hash(const std::string& text) {
    return text.size() == hash_digits && text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

Error damaged(const std::string& what) {
    return invalid_input("the stored tiles are damaged: " + what);
}

// From the coarsest level, the root, to the finest.
TileTree chain_of_levels(const proto::Asset& asset) {
    Box box;
    box.add({(*asset.bounds_min)[0], (*asset.bounds_min)[1], (*asset.bounds_min)[2]});
    box.add({(*asset.bounds_max)[0], (*asset.bounds_max)[1], (*asset.bounds_max)[2]});
    TileTree tree;
    double error = 0.0;  // never falls on the way up
    for (const proto::Level& level : asset.levels) {
        error = std::max(error, level.max_error);
        scene::LodNode node;
        node.box = box;
        node.error = error;
        node.triangles = level.triangles;
        tree.nodes.push_back(node);
        tree.hashes.push_back(level.url.substr(std::min(content_prefix.size(), level.url.size()), hash_digits));
        tree.bytes.push_back(level.bytes);
    }
    std::reverse(tree.nodes.begin(), tree.nodes.end());
    std::reverse(tree.hashes.begin(), tree.hashes.end());
    std::reverse(tree.bytes.begin(), tree.bytes.end());
    for (std::uint32_t i = 1; i < tree.nodes.size(); ++i) {
        tree.nodes[i].parent = i - 1;
        tree.nodes[i - 1].first_child = i;
        tree.nodes[i - 1].child_count = 1;
    }
    return tree;
}

}  // namespace

std::vector<std::byte> serialize(const TileTree& tree) {
    Writer writer;
    writer.magic(magic);
    writer(static_cast<std::uint64_t>(tree.nodes.size()));
    for (std::size_t i = 0; i < tree.nodes.size(); ++i) {
        describe_node(writer, tree.nodes[i]);
        writer(tree.hashes[i]);
        writer(tree.bytes[i]);
    }
    writer(tree.matrices);
    return std::move(writer.bytes);
}

Result<TileTree> open_tile_tree(std::span<const std::byte> bytes) {
    const bool is_older = Reader(bytes).magic(older_magic);
    Reader reader(bytes);
    if (!reader.magic(magic) && !is_older) return damaged("they do not start with LODTILE2");
    std::uint64_t count = 0;
    reader(count);
    TileTree tree;
    for (std::uint64_t i = 0; i < count && reader.ok(); ++i) {
        describe_node(reader, tree.nodes.emplace_back());
        reader(tree.hashes.emplace_back());
        reader(tree.bytes.emplace_back());
    }
    if (!is_older) reader(tree.matrices);
    if (!reader.ok() || !reader.at_end()) return damaged("they end too early or too late");
    if (Status valid = scene::validate(tree.nodes); !valid) return damaged(valid.error().message);
    if (!std::all_of(tree.hashes.begin(), tree.hashes.end(), is_hash)) return damaged("a content's name is no hash");
    if (!tree.matrices.empty() && tree.matrices.size() != tree.nodes.size()) return damaged("some have no place");
    for (const Mat4d& matrix : tree.matrices)
        if (Status valid = scene::validate({matrix, true}); !valid) return damaged("a place " + valid.error().message);
    return tree;
}

Result<TileTree> load_tiles(const store::Store& store, const proto::Asset& asset) {
    if (asset.status == proto::AssetStatus::baking)
        return fail(ErrorCode::unavailable, "\"" + asset.name + "\" is still baking");
    if (asset.status == proto::AssetStatus::failed)
        return fail(ErrorCode::conflict, "\"" + asset.name + "\" has no tileset: " + asset.error);
    if (Result<store::Store::Content> stored = store.content(asset.id, tiles_key); stored) {
        Result<std::vector<std::byte>> bytes = store::read_file(stored->file.path, max_tiles_bytes);
        if (!bytes) return bytes.error();
        Result<TileTree> tree = open_tile_tree(*bytes);
        if (tree) tree->is_additive = asset.kind == mesh::kind_name(mesh::Kind::points);
        return tree;
    }
    if (asset.levels.empty() || !asset.bounds_min || !asset.bounds_max)
        return fail(ErrorCode::conflict, "\"" + asset.name + "\" has no tileset: it has no bounds or levels");
    return chain_of_levels(asset);
}

}  // namespace lodestream::bake
