// Tilesets that are told in several documents.
#include <gmock/gmock.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "common/base/random.h"
#include "common/base/transform.h"
#include "proto/tileset.h"

namespace lodestream::proto {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Json = nlohmann::json;

// Of so many tiles, three below each, boxes within boxes; every seventh one is placed by a matrix of its own.
Tileset tree_of(std::uint32_t tiles) {
    Tileset tileset;
    Random random(3);
    scene::LodNode root;
    root.box = {Vec3d(-1000.0), Vec3d(1000.0)};
    root.error = 1000.0;
    root.triangles = 900;
    tileset.nodes.push_back(root);
    for (std::uint32_t i = 0; tileset.nodes.size() < tiles; ++i) {
        tileset.nodes[i].first_child = static_cast<std::uint32_t>(tileset.nodes.size());
        for (; tileset.nodes[i].child_count < 3 && tileset.nodes.size() < tiles; ++tileset.nodes[i].child_count) {
            scene::LodNode child = tileset.nodes[i];
            child.parent = i;
            child.first_child = child.child_count = 0;
            child.error *= 0.5;
            child.box.min += 0.1 * random.uniform() * child.box.extent();
            tileset.nodes.push_back(child);
        }
    }
    for (std::uint32_t i = 0; i < tiles; ++i) {
        tileset.uris.push_back("/v1/content/" + std::to_string(i) + ".glb");
        tileset.bytes.push_back(10 + i);
        tileset.matrices.push_back(i % 7 == 3 ? matrix_of({1.0 * i, 2, 3}, {0, 0.6, 0, 0.8}, {2, 2, 2}) : Mat4d(1.0));
        tileset.ids.push_back(1'000'000 + i);
        tileset.scene_nodes.push_back(i % 5 == 0 ? i : no_scene_node);
    }
    tileset.revision = 12;
    return tileset;
}

std::string address(std::uint64_t id, std::uint64_t version) {
    return "/t.json?tile=" + std::to_string(id) + "&version=" + std::to_string(version);
}

Tileset split(Tileset tileset) {
    split_into_documents(tileset, address);
    return tileset;
}

std::uint32_t node_of(const Tileset& tileset, const std::string& document) {
    return static_cast<std::uint32_t>(std::ranges::find(tileset.documents, document) - tileset.documents.begin());
}

// As a client has it that reads all documents.
Tileset read_all(const Tileset& served) {
    Tileset read = *parse_tileset(to_json(served));
    for (std::uint32_t node = 0; node < read.nodes.size(); ++node) {
        if (!begins_document(read, node)) continue;
        const auto document = parse_document(to_json(served, node_of(served, read.documents[node])), read.matrix(node));
        EXPECT_TRUE(document.ok()) << document.error().message;
        EXPECT_TRUE(add_document(read, node, *document).ok());
    }
    return read;
}

TEST(TilesetDocuments, SmallTilesetsAreOne) {
    const Tileset tileset = split(tree_of(max_document_tiles));
    EXPECT_THAT(tileset.documents, IsEmpty());
    EXPECT_EQ(to_json(tileset), to_json(tree_of(max_document_tiles)));
}

TEST(TilesetDocuments, EachHasAFewOfTheTilesAndAllTogetherEachOnce) {
    const Tileset tileset = split(tree_of(20'000));
    const auto count = [&](std::uint32_t document) {
        const std::string json = to_json(tileset, document);
        std::size_t tiles = 0;
        for (std::size_t at = 0; (at = json.find("\"boundingVolume\"", at)) != std::string::npos; ++at) ++tiles;
        return tiles;
    };
    std::size_t documents = 0, all = count(0);
    EXPECT_LT(all, 3 * max_document_tiles);
    for (std::uint32_t i = 0; i < tileset.nodes.size(); ++i) {
        if (!begins_document(tileset, i)) continue;
        const std::size_t tiles = count(i);
        EXPECT_LE(tiles, max_document_tiles);
        EXPECT_GT(tiles, 1u);
        all += tiles - 1;  // its first tile is named in the root's document too
        ++documents;
    }
    EXPECT_GT(documents, 20u);
    EXPECT_EQ(all, tileset.nodes.size());
}

TEST(TilesetDocuments, ReadTogetherTheyAreTheTileset) {
    const Tileset sent = split(tree_of(3'000)), read = read_all(sent);
    ASSERT_EQ(read.nodes.size(), sent.nodes.size());
    ASSERT_TRUE(scene::validate(read.nodes).ok());
    ASSERT_EQ(read.ids.size(), sent.ids.size());
    EXPECT_EQ(read.revision, sent.revision);
    std::map<std::uint64_t, std::uint32_t> places;
    for (std::uint32_t i = 0; i < read.nodes.size(); ++i) places[read.ids[i]] = i;
    for (std::uint32_t i = 0; i < sent.nodes.size(); ++i) {
        const std::uint32_t k = places.at(sent.ids[i]);
        const scene::LodNode &a = sent.nodes[i], &b = read.nodes[k];
        EXPECT_EQ(read.uris[k], sent.uris[i]);
        EXPECT_EQ(read.bytes[k], sent.bytes[i]);
        EXPECT_EQ(read.scene_nodes[k], sent.scene_nodes[i]);
        EXPECT_EQ(b.triangles, a.triangles);
        EXPECT_EQ(b.child_count, a.child_count);
        EXPECT_NEAR(b.error, a.error, 1e-9 * (1.0 + a.error));
        if (i > 0) {
            EXPECT_EQ(read.ids[b.parent], sent.ids[a.parent]);
        }
        for (int c = 0; c < 4; ++c) EXPECT_LT(distance(Vec3d(read.matrix(k)[c]), Vec3d(sent.matrix(i)[c])), 1e-6) << i;
        // A turned box comes back as the box around it.
        EXPECT_TRUE(glm::all(glm::lessThanEqual(b.box.min, a.box.min + 1e-6))) << i;
        EXPECT_TRUE(glm::all(glm::greaterThanEqual(b.box.max, a.box.max - 1e-6))) << i;
        EXPECT_FALSE(begins_document(read, k));
    }
}

TEST(TilesetDocuments, ATileThatBeginsOneTellsItsContentInBoth) {
    const Tileset sent = split(tree_of(3'000));
    const Tileset root = *parse_tileset(to_json(sent));
    std::size_t documents = 0;
    for (std::uint32_t node = 0; node < root.nodes.size(); ++node) {
        if (!begins_document(root, node)) continue;
        ++documents;
        EXPECT_EQ(root.nodes[node].child_count, 0u);
        const std::uint32_t i = node_of(sent, root.documents[node]);
        EXPECT_EQ(root.uris[node], sent.uris[i]);
        const Json json = Json::parse(to_json(sent, i));
        EXPECT_EQ(json["root"]["content"]["uri"], sent.uris[i]);
        EXPECT_FALSE(json["root"].contains("transform")) << "the tile that names it has placed it";
        EXPECT_EQ(json["asset"]["tilesetVersion"], "12");
    }
    EXPECT_GT(documents, 3u);
}

TEST(TilesetDocuments, OnlyThoseThatAChangeIsInGetAnotherAddress) {
    Tileset changed = tree_of(3'000);
    const Tileset before = split(changed);
    changed.matrices.back() = matrix_of({5, 5, 5}, {0, 0, 0, 1}, {1, 1, 1});
    const Tileset after = split(changed);
    std::uint32_t holder = static_cast<std::uint32_t>(before.nodes.size() - 1);
    while (!begins_document(before, holder)) holder = before.nodes[holder].parent;
    for (std::uint32_t i = 0; i < before.nodes.size(); ++i)
        EXPECT_EQ(before.documents[i] == after.documents[i], i != holder) << i;
    changed.uris.back() += "x";
    EXPECT_NE(split(changed).documents[holder], after.documents[holder]);
    changed.nodes.back().error *= 0.5;
    EXPECT_NE(split(changed).documents[holder], after.documents[holder]);
}

TEST(TilesetDocuments, TilesWithoutIdsGetTheirNumbers) {
    Tileset tileset = tree_of(max_document_tiles + 1);
    tileset.ids.clear();
    tileset.matrices.clear();
    tileset.scene_nodes.clear();
    const Tileset read = read_all(split(std::move(tileset)));
    EXPECT_EQ(read.nodes.size(), max_document_tiles + 1);
    EXPECT_THAT(read.matrices, IsEmpty());
    const std::set<std::uint64_t> ids(read.ids.begin(), read.ids.end());
    EXPECT_EQ(*ids.rbegin(), max_document_tiles);
}

TEST(TilesetDocuments, WhoseContentIsNotToldAreNoneOfOurs) {
    Json json = Json::parse(to_json(tree_of(2)));
    json["root"]["children"][0]["content"]["uri"] = "more/tileset.json";
    const auto refused = parse_tileset(json.dump());
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, ErrorCode::unsupported);
    EXPECT_THAT(refused.error().message, HasSubstr("tile 1"));
    json["root"]["children"][0]["extras"]["content"] = "a.glb";
    const auto read = parse_tileset(json.dump());
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_EQ(read->documents[1], "more/tileset.json");
    EXPECT_EQ(read->uris[1], "a.glb");
}

TEST(TilesetDocuments, MoreTilesThanThereMayBeAreRefused) {
    Tileset tileset = tree_of(2);
    tileset.documents = {"", "/more.json"};
    Tileset document = tree_of(2);
    document.nodes.resize(max_tiles);
    EXPECT_EQ(add_document(tileset, 1, document).error().code, ErrorCode::limit_exceeded);
}

}  // namespace
}  // namespace lodestream::proto
