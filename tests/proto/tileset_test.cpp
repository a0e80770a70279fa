#include "proto/tileset.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/base/transform.h"

namespace lodestream::proto {
namespace {

scene::LodNode tile(double error, std::uint32_t parent, std::uint32_t first_child, std::uint32_t child_count) {
    scene::LodNode node;
    node.box.add({1.0, 2.0, 3.0});
    node.box.add({3.0, 6.0, 13.0});
    node.error = error;
    node.parent = parent;
    node.first_child = first_child;
    node.child_count = child_count;
    return node;
}

Tileset tileset_of(const scene::LodTree& tree) {
    Tileset tileset{tree, {}, std::vector<std::uint64_t>(tree.size(), 100)};
    for (std::size_t i = 0; i < tree.size(); ++i) tileset.uris.push_back(std::to_string(i) + ".glb");
    return tileset;
}

nlohmann::json parsed_tileset(const scene::LodTree& tree) {
    return nlohmann::json::parse(to_json(tileset_of(tree)));
}

TEST(Tileset, IsTheTreeWithItsErrors) {
    const auto tileset =
        parsed_tileset({tile(2.0, scene::none, 1, 2), tile(0.5, 0, 3, 1), tile(0.0, 0, 0, 0), tile(0.25, 1, 0, 0)});
    EXPECT_EQ(tileset["asset"]["version"], "1.1");
    const auto& root = tileset["root"];
    EXPECT_GT(tileset["geometricError"], root["geometricError"]);
    EXPECT_EQ(root["refine"], "REPLACE");
    EXPECT_EQ(root["geometricError"], 2.0);
    EXPECT_EQ(root["content"]["uri"], "0.glb");
    ASSERT_EQ(root["children"].size(), 2u);
    EXPECT_EQ(root["children"][0]["content"]["uri"], "1.glb");
    EXPECT_EQ(root["children"][0]["children"][0]["geometricError"], 0.25);
    EXPECT_EQ(root["children"][1]["content"]["uri"], "2.glb");
    EXPECT_FALSE(root["children"][1].contains("children"));
}

TEST(Tileset, OfPointsAddsAndComesBack) {
    Tileset tileset = tileset_of({tile(2.0, scene::none, 1, 1), tile(0.0, 0, 0, 0)});
    tileset.is_additive = true;
    nlohmann::json json = nlohmann::json::parse(to_json(tileset));
    EXPECT_EQ(json["root"]["refine"], "ADD");
    const Result<Tileset> back = parse_tileset(json.dump());
    ASSERT_TRUE(back.ok()) << back.error().message;
    EXPECT_TRUE(back->is_additive);
    EXPECT_EQ(to_json(*back), to_json(tileset));
    json["root"]["children"][0]["refine"] = "REPLACE";
    EXPECT_EQ(parse_tileset(json.dump()).error().code, ErrorCode::unsupported);
    json["root"]["refine"] = "SOMEHOW";
    EXPECT_EQ(parse_tileset(json.dump()).error().code, ErrorCode::invalid_input);
}

TEST(Tileset, TurnsTheBoxToZUp) {
    const auto tileset = parsed_tileset({tile(0.0, scene::none, 0, 0)});
    const std::vector<double> box = tileset["root"]["boundingVolume"]["box"];
    EXPECT_EQ(box, (std::vector<double>{2, -8, 4, 1, 0, 0, 0, 5, 0, 0, 0, 2}));
}

TEST(Tileset, StaysFiniteAtTheEdgesOfDouble) {
    scene::LodNode node = tile(0.0, scene::none, 0, 0);
    node.box.add({-1.5e308, 0.0, 0.0});
    node.box.add({1.5e308, 0.0, 0.0});
    const auto tileset = parsed_tileset({node});
    EXPECT_EQ(tileset["root"]["boundingVolume"]["box"][3], 1.5e308);
    EXPECT_TRUE(tileset["geometricError"].is_number());
}

TEST(Tileset, ChainOfAHundredThousandTilesNeedsNoStack) {
    scene::LodTree tree;
    for (std::uint32_t i = 0; i < 100'000; ++i) tree.push_back(tile(1.0, i == 0 ? scene::none : i - 1, i + 1, 1));
    tree.back() = tile(1.0, 99'998, 0, 0);
    const std::string json = to_json(tileset_of(tree));
    EXPECT_EQ(std::count(json.begin(), json.end(), '{'), std::count(json.begin(), json.end(), '}'));
}

scene::LodTree small_tree() {
    return {tile(2.0, scene::none, 1, 2), tile(0.5, 0, 3, 1), tile(0.0, 0, 0, 0), tile(0.25, 1, 0, 0)};
}

TEST(Tileset, ComesBackAsItWent) {
    scene::LodTree tree = small_tree();
    tree[2].triangles = 1'234;
    const Result<Tileset> back = parse_tileset(to_json(tileset_of(tree)));
    ASSERT_TRUE(back.ok()) << back.error().message;
    ASSERT_EQ(back->nodes.size(), 4u);
    EXPECT_EQ(back->nodes[2].triangles, 1'234u);
    EXPECT_EQ(back->bytes[3], 100u);
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_EQ(back->uris[i], std::to_string(i) + ".glb");
        EXPECT_EQ(back->nodes[i].error, tree[i].error);
        EXPECT_EQ(back->nodes[i].parent, tree[i].parent);
        EXPECT_EQ(back->nodes[i].box.min, tree[i].box.min);
        EXPECT_EQ(back->nodes[i].box.max, tree[i].box.max);
    }
    EXPECT_EQ(to_json(*back), to_json(tileset_of(tree)));
}

TEST(Tileset, ParentsOfOthersAreMadeToHoldTheirChildren) {
    nlohmann::json json = parsed_tileset(small_tree());
    json["root"]["children"][0]["children"][0]["geometricError"] = 9.0;
    json["root"]["children"][1]["boundingVolume"]["box"] = {100, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1};
    const Result<Tileset> read = parse_tileset(json.dump());
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_EQ(read->nodes[0].error, 9.0);
    EXPECT_EQ(read->nodes[0].box.max.x, 101.0);
    EXPECT_EQ(read->nodes[2].box.max.z, 2.0);  // of an oriented one the box around it, turned to y up
}

TEST(Tileset, RefusesWhatItCannotShow) {
    const nlohmann::json good = parsed_tileset(small_tree());
    const auto refused = [&](auto change, ErrorCode code) {
        nlohmann::json bad = good;
        change(bad["root"]["children"][0]);
        const Result<Tileset> read = parse_tileset(bad.dump());
        ASSERT_FALSE(read.ok()) << bad.dump();
        EXPECT_EQ(read.error().code, code) << read.error().message;
        EXPECT_NE(read.error().message.find("tile 1"), std::string::npos) << read.error().message;
    };
    using Json = nlohmann::json;
    refused([](Json& t) { t["refine"] = "ADD"; }, ErrorCode::unsupported);
    refused([](Json& t) { t.erase("content"); }, ErrorCode::unsupported);
    refused([](Json& t) { t["boundingVolume"] = {{"sphere", {0, 0, 0, 1}}}; }, ErrorCode::unsupported);
    refused([](Json& t) { t["boundingVolume"]["box"].erase(0); }, ErrorCode::invalid_input);
    refused([](Json& t) { t["boundingVolume"]["box"][0] = 1e308, t["boundingVolume"]["box"][3] = 1.7e308; },
            ErrorCode::invalid_input);
    refused([](Json& t) { t.erase("geometricError"); }, ErrorCode::invalid_input);
    refused([](Json& t) { t["extras"]["triangles"] = -1; }, ErrorCode::invalid_input);
    refused([](Json& t) { t = 7; }, ErrorCode::invalid_input);
    for (const char* text : {"", "[]", "{}", "{\"root\":7}", "{\"root\":{}}", "{\"root\":"})
        EXPECT_FALSE(parse_tileset(text).ok()) << text;
}

TEST(Tileset, RefusesTruncationsAndSurvivesFlippedBytes) {
    const std::string json = to_json(tileset_of(small_tree()));
    for (std::size_t size = 0; size < json.size(); ++size) EXPECT_FALSE(parse_tileset(json.substr(0, size)).ok());
    for (std::size_t i = 0; i < json.size(); ++i) {
        std::string damaged = json;
        damaged[i] = static_cast<char>(damaged[i] ^ 0x15);
        const Result<Tileset> read = parse_tileset(damaged);
        EXPECT_TRUE(!read.ok() || scene::validate(read->nodes).ok());
    }
}

TEST(Tileset, RefusesAChainThatIsTooDeep) {
    std::string json = R"({"asset":{"version":"1.1"},"root":)", end = "}";
    for (int i = 0; i < 10'000; ++i) {
        json += R"({"children":[)";
        end += "]}";
    }
    EXPECT_FALSE(parse_tileset(json + end).ok());
}

Tileset moved_tileset() {
    Tileset tileset =
        tileset_of({tile(2.0, scene::none, 1, 2), tile(0.5, 0, 3, 1), tile(0.0, 0, 0, 0), tile(0.25, 1, 0, 0)});
    const Mat4d turned = matrix_of({10, 20, 30}, {0, 0, 0.6, 0.8}, {2, 2, 2});
    for (scene::LodNode& node : tileset.nodes) node.box.add({100, 100, 100});
    tileset.matrices = {Mat4d(1.0), turned, Mat4d(1.0), turned};
    tileset.scene_nodes = {no_scene_node, 7, no_scene_node, no_scene_node};
    tileset.ids = {0, 1, 2, 1ull << 33};
    tileset.revision = 42;
    return tileset;
}

TEST(Tileset, WhatHasMovedComesBackWhereItIs) {
    const Tileset sent = moved_tileset();
    const auto came = parse_tileset(to_json(sent));
    ASSERT_TRUE(came) << came.error().message;
    EXPECT_EQ(came->revision, 42u);
    EXPECT_EQ(came->ids, sent.ids);
    ASSERT_EQ(came->matrices.size(), sent.nodes.size());
    for (std::size_t i = 0; i < sent.nodes.size(); ++i) {
        EXPECT_NEAR(came->nodes[i].error, sent.nodes[i].error, 1e-12);
        EXPECT_LT(distance(came->nodes[i].box.min, sent.nodes[i].box.min), 1e-9) << i;
        EXPECT_LT(distance(came->nodes[i].box.max, sent.nodes[i].box.max), 1e-9) << i;
        for (int k = 0; k < 4; ++k) EXPECT_LT(distance(came->matrices[i][k], sent.matrices[i][k]), 1e-12);
        EXPECT_EQ(came->scene_nodes[i], sent.scene_nodes[i]);
    }
}

TEST(Tileset, ATransformIsZUpAndInForceBelow) {
    const auto json = nlohmann::json::parse(to_json(moved_tileset()));
    EXPECT_EQ(json["asset"]["tilesetVersion"], "42");
    const auto& moved = json["root"]["children"][0];
    const std::vector<double> matrix = moved["transform"];
    EXPECT_EQ((std::vector<double>(matrix.begin() + 12, matrix.end())), (std::vector<double>{10, -30, 20, 1}));
    EXPECT_EQ(moved["geometricError"], 0.25) << "viewers multiply it by the transform's scale";
    EXPECT_EQ(moved["extras"]["node"], 7);
    EXPECT_FALSE(moved["children"][0].contains("transform"));
    EXPECT_FALSE(json["root"].contains("transform"));
    EXPECT_FALSE(parsed_tileset({tile(0.0, scene::none, 0, 0)})["asset"].contains("tilesetVersion"));
}

TEST(Tileset, HostileTransformsAreRefused) {
    for (const char* transform : {"[1,2]", "\"x\"", "[1,0,0,0,0,1,0,0,0,0,1,0,1e300,0,0,1]",
                                  "[0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,1]", "[1,0,0,5,0,1,0,0,0,0,1,0,0,0,0,1]"}) {
        std::string json = to_json(tileset_of({tile(0.0, scene::none, 0, 0)}));
        json.replace(json.find("\"boundingVolume\""), 0, std::string("\"transform\":") + transform + ",");
        const auto tileset = parse_tileset(json);
        ASSERT_FALSE(tileset) << transform;
        EXPECT_NE(tileset.error().message.find("transform"), std::string::npos) << tileset.error().message;
    }
}

}  // namespace
}  // namespace lodestream::proto
