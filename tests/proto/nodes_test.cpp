#include "proto/nodes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace lodestream::proto {
namespace {

using ::testing::HasSubstr;

std::string refusal(const std::string& json) {
    const auto changes = parse_node_changes(json);
    return changes ? "taken" : changes.error().message;
}

std::string with_matrix(const std::string& numbers) {
    return R"({"nodes":[{"node":1,"matrix":[)" + numbers + "]}]}";
}

TEST(NodeChanges, PartsMakeTheMatrixThatGltfMakesOfThem) {
    const auto changes = parse_node_changes(
        R"({"nodes":[{"node":2,"translation":[1,2,3],"rotation":[0,0.7071067811865476,0,0.7071067811865476],"scale":[2,3,4]}]})");
    ASSERT_TRUE(changes) << changes.error().message;
    const Mat4d& m = *changes->front().matrix;
    const auto at = [&](const Vec3d& p) { return Vec3d(m * Vec4d(p, 1.0)); };
    EXPECT_LT(distance(at({0, 0, 0}), Vec3d(1, 2, 3)), 1e-12);
    EXPECT_LT(distance(at({1, 0, 0}), Vec3d(1, 2, 1)), 1e-12);  // a quarter turn about y takes +x to -z
    EXPECT_LT(distance(at({0, 1, 0}), Vec3d(1, 5, 3)), 1e-12);
    EXPECT_LT(distance(at({0, 0, 1}), Vec3d(5, 2, 3)), 1e-12);
    EXPECT_FALSE(changes->front().visible);
}

TEST(NodeChanges, HostileMatricesAreNamed) {
    EXPECT_THAT(refusal(with_matrix("0,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1")), HasSubstr("nodes[0].matrix is singular"));
    EXPECT_THAT(refusal(with_matrix("1,0,0,0, 0,1,0,0, 1,1,0,0, 0,0,0,1")), HasSubstr("singular"));
    EXPECT_THAT(refusal(with_matrix("1e300,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1")), HasSubstr("scales by more"));
    EXPECT_THAT(refusal(with_matrix("1e-9,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1")), HasSubstr("less than"));
    EXPECT_THAT(refusal(with_matrix("1,0,0,0, 0,1,0,0, 0,0,1,0, 1e300,0,0,1")), HasSubstr("moves farther"));
    EXPECT_THAT(refusal(with_matrix("1,0,0,1, 0,1,0,0, 0,0,1,0, 0,0,0,1")), HasSubstr("affine"));
    EXPECT_THAT(refusal(with_matrix("1,0,0")), HasSubstr("16 numbers"));
    EXPECT_THAT(refusal(with_matrix("NaN,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1")), HasSubstr("JSON"));
    EXPECT_NE(refusal(with_matrix("1e999,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1")), "taken");
}

TEST(NodeChanges, EveryOtherMistakeIsNamed) {
    EXPECT_THAT(refusal("{}"), HasSubstr("nodes is missing"));
    EXPECT_THAT(refusal(R"({"nodes":[]})"), HasSubstr("must not be empty"));
    EXPECT_THAT(refusal(R"({"nodes":{}})"), HasSubstr("nodes must be an array"));
    EXPECT_THAT(refusal(R"({"nodes":[{"node":1}]})"), HasSubstr("must be given"));
    EXPECT_THAT(refusal(R"({"nodes":[{"visible":true}]})"), HasSubstr("nodes[0].node is missing"));
    EXPECT_THAT(refusal(R"({"nodes":[{"node":-1,"visible":true}]})"), HasSubstr("nodes[0].node"));
    EXPECT_THAT(refusal(R"({"nodes":[{"node":1,"visible":1}]})"), HasSubstr("true or false"));
    EXPECT_THAT(refusal(R"({"nodes":[{"node":1,"visible":true},{"node":1,"visible":false}]})"),
                HasSubstr("nodes[1].node is there twice"));
    EXPECT_THAT(refusal(R"({"nodes":[{"node":1,"rotation":[0,0,0,0]}]})"), HasSubstr("quaternion"));
    EXPECT_THAT(refusal(R"({"nodes":[{"node":1,"scale":[0,1,1]}]})"), HasSubstr("singular"));
    EXPECT_THAT(refusal(R"({"nodes":[{"node":1,"scale":[1,1,1],"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]}]})"),
                HasSubstr("must not be beside"));
}

TEST(NodeChanges, AnAssetMayBeShownAndANewNodeNeedsNoNumber) {
    const auto changes = parse_node_changes(
        R"({"nodes":[{"node":2,"asset":"crate"},{"parent":0,"asset":"crate"},{"parent":2,"asset":"crate"},{"node":9,"parent":1,"asset":""}]})");
    ASSERT_TRUE(changes) << changes.error().message;
    EXPECT_EQ(changes->at(0).asset, "crate");
    EXPECT_FALSE(changes->at(0).parent);
    EXPECT_EQ(changes->at(1).node, next_node);
    EXPECT_EQ(changes->at(2).parent, 2u);
    EXPECT_EQ(changes->at(3).node, 9u);
    EXPECT_EQ(changes->at(3).asset, "");
    const auto again = parse_node_changes(to_json(*changes));
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_EQ(to_json(*again), to_json(*changes));
    EXPECT_THAT(refusal(R"({"nodes":[{"parent":0}]})"), HasSubstr("asset must be given"));
    EXPECT_THAT(refusal(R"({"nodes":[{"parent":-1,"asset":"crate"}]})"), HasSubstr("nodes[0].parent"));
    EXPECT_THAT(refusal(R"({"nodes":[{"parent":4294967295,"asset":"crate"}]})"), HasSubstr("nodes[0].parent"));
    EXPECT_THAT(refusal(R"({"nodes":[{"node":4294967295,"asset":"crate"}]})"), HasSubstr("nodes[0].node"));
    EXPECT_THAT(refusal(R"({"nodes":[{"node":1,"asset":3}]})"), HasSubstr("nodes[0].asset"));
    EXPECT_THAT(refusal(R"({"nodes":[{"node":1,"asset":")" + std::string(max_asset_name + 1, 'a') + "\"}]}"),
                HasSubstr("at most 256"));
}

TEST(NodesChanged, TellsTheNumbersOfNewNodes) {
    const NodesChanged changed{7, 2, {31, 32}};
    const auto back = parse_nodes_changed(to_json(changed));
    ASSERT_TRUE(back);
    EXPECT_EQ(back->added, changed.added);
    EXPECT_FALSE(parse_nodes_changed(R"({"revision":7,"moved_objects":2,"added":["x"]})"));
}

TEST(NodeChanges, TooManyAreALimit) {
    std::string text = R"({"nodes":[)";
    for (std::size_t i = 0; i <= max_node_changes; ++i)
        text += (i > 0 ? "," : "") + (R"({"node":)" + std::to_string(i) + R"(,"visible":false})");
    const auto changes = parse_node_changes(text + "]}");
    ASSERT_FALSE(changes);
    EXPECT_EQ(changes.error().code, ErrorCode::limit_exceeded);
}

}  // namespace
}  // namespace lodestream::proto
