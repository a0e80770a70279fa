#include "common/scene/hierarchy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/base/random.h"

namespace lodestream::scene {
namespace {

Object unit_box_at(const Vec3d& place, std::uint64_t triangles = 100, std::uint32_t graph_node = 0) {
    return {{place, place + Vec3d{1.0}}, triangles, graph_node};
}

std::vector<Object> scattered(std::size_t count, std::uint64_t seed = 1) {
    Random random(seed);
    std::vector<Object> objects;
    for (std::size_t i = 0; i < count; ++i)
        objects.push_back(unit_box_at({random.uniform(0, 1e3), random.uniform(0, 1e2), random.uniform(0, 1e3)},
                                      1 + random.next() % 1'000));
    return objects;
}

std::size_t depth_of(const Hierarchy& hierarchy) {
    std::vector<std::size_t> depth(hierarchy.nodes.size(), 1);
    for (std::size_t i = 1; i < depth.size(); ++i) depth[i] = depth[hierarchy.nodes[i].parent] + 1;
    return depth.empty() ? 0 : *std::max_element(depth.begin(), depth.end());
}

// The laws that every hierarchy keeps.
void expect_sound(const Hierarchy& hierarchy, const std::vector<Object>& objects, const HierarchyOptions& options) {
    std::vector<int> seen(objects.size(), 0);
    for (const std::uint32_t object : hierarchy.objects) ++seen[object];
    for (std::size_t i = 0; i < objects.size(); ++i) ASSERT_EQ(seen[i], objects[i].triangles > 0 ? 1 : 0);
    for (std::uint32_t i = 0; i < hierarchy.nodes.size(); ++i) {
        const HierarchyNode& node = hierarchy.nodes[i];
        ASSERT_GT(node.object_count, 0u);
        ASSERT_NE(node.child_count, 1u);
        ASSERT_LE(node.child_count, options.max_children);
        if (node.child_count == 0) {
            ASSERT_TRUE(node.object_count == 1 || node.triangles <= options.leaf_triangles);
        }
        std::uint32_t next = node.first_object;
        std::uint64_t triangles = 0;
        for (std::uint32_t k = 0; k < node.child_count; ++k) {
            const HierarchyNode& child = hierarchy.nodes[node.first_child + k];
            ASSERT_EQ(child.parent, i);
            ASSERT_GT(node.first_child, i);
            ASSERT_EQ(child.first_object, next);
            next += child.object_count;
            triangles += child.triangles;
            ASSERT_EQ(glm::max(node.box.max, child.box.max), node.box.max);
            ASSERT_EQ(glm::min(node.box.min, child.box.min), node.box.min);
        }
        if (node.child_count > 0) {
            ASSERT_EQ(next, node.first_object + node.object_count);
            ASSERT_EQ(triangles, node.triangles);
        }
    }
    // A child has at most 7/8 of its parent's objects.
    const double count = static_cast<double>(std::max<std::size_t>(1, hierarchy.objects.size()));
    EXPECT_LE(static_cast<double>(depth_of(hierarchy)), 2.0 + std::log(count) / std::log(8.0 / 7.0));
}

Hierarchy sound_hierarchy(const std::vector<Object>& objects, const std::vector<std::uint32_t>& parents,
                          const HierarchyOptions& options = {}) {
    Hierarchy hierarchy = build_hierarchy(objects, parents, options);
    expect_sound(hierarchy, objects, options);
    return hierarchy;
}

TEST(Hierarchy, OfNothingHasNoNodes) {
    EXPECT_TRUE(sound_hierarchy({}, {}).nodes.empty());
    EXPECT_TRUE(sound_hierarchy({{{}, 0, 0}, {{}, 0, 0}}, {}).nodes.empty());
}

TEST(Hierarchy, OfOneObjectIsOneLeaf) {
    EXPECT_EQ(sound_hierarchy({unit_box_at({0, 0, 0}, 1'000'000)}, {}).nodes.size(), 1u);
}

TEST(Hierarchy, SmallObjectsTogetherAreOneLeaf) {
    EXPECT_EQ(sound_hierarchy(scattered(10), {}).nodes.size(), 1u);
}

TEST(Hierarchy, LeavesOutEmptyNodes) {
    const std::vector<std::uint32_t> parents{none, 0, 0, 1, 2, 2};
    std::vector<Object> objects{unit_box_at({0, 0, 0}, 20'000, 3), unit_box_at({9, 0, 0}, 20'000, 5)};
    objects.push_back({{}, 0, 4});
    const Hierarchy hierarchy = sound_hierarchy(objects, parents);
    EXPECT_EQ(hierarchy.nodes.size(), 3u);
}

TEST(Hierarchy, FollowsAGraphThatDividesSpace) {
    // Two rooms of unlike size; halving by triangles would cut through the larger one.
    const std::vector<std::uint32_t> parents{none, 0, 0};
    std::vector<Object> objects;
    for (int i = 0; i < 6; ++i) objects.push_back(unit_box_at({i * 2.0, 0, 0}, 10'000, 1));
    for (int i = 0; i < 4; ++i) objects.push_back(unit_box_at({100.0 + i * 2.0, 0, 0}, 10'000, 2));
    HierarchyOptions options;
    options.max_children = 2;
    const Hierarchy hierarchy = sound_hierarchy(objects, parents, options);
    ASSERT_EQ(hierarchy.nodes[0].child_count, 2u);
    EXPECT_EQ(hierarchy.nodes[1].object_count, 6u);
    EXPECT_EQ(hierarchy.nodes[2].object_count, 4u);
}

TEST(Hierarchy, DividesSpaceWhereTheGraphGroupsByKind) {
    // Two kinds of objects, each all over the place.
    const std::vector<std::uint32_t> parents{none, 0, 0};
    std::vector<Object> objects = scattered(2'000);
    for (std::size_t i = 0; i < objects.size(); ++i) objects[i].graph_node = 1 + i % 2;
    const Hierarchy hierarchy = sound_hierarchy(objects, parents);
    for (std::uint32_t k = 0; k < hierarchy.nodes[0].child_count; ++k)
        EXPECT_LT(hierarchy.nodes[hierarchy.nodes[0].first_child + k].box.diagonal(),
                  0.8 * hierarchy.nodes[0].box.diagonal());
}

TEST(Hierarchy, SeveralRootsAreDividedToo) {
    const std::vector<std::uint32_t> parents{none, none, none};
    std::vector<Object> objects;
    for (std::uint32_t i = 0; i < 3; ++i) objects.push_back(unit_box_at({10.0 * i, 0, 0}, 50'000, i));
    EXPECT_EQ(sound_hierarchy(objects, parents).nodes[0].child_count, 3u);
}

TEST(Hierarchy, OfAChainTenThousandDeepIsShallow) {
    constexpr std::uint32_t count = 10'000;
    std::vector<std::uint32_t> parents{none};
    std::vector<Object> objects;
    for (std::uint32_t i = 0; i < count; ++i) {
        if (i > 0) parents.push_back(i - 1);
        objects.push_back(unit_box_at({2.0 * i, 0, 0}, 20'000, i));
    }
    EXPECT_LE(depth_of(sound_hierarchy(objects, parents)), 12u);
}

TEST(Hierarchy, OfAnEmptyChainTenThousandDeepIsItsEnd) {
    constexpr std::uint32_t count = 10'000;
    std::vector<std::uint32_t> parents{none};
    for (std::uint32_t i = 1; i < count; ++i) parents.push_back(i - 1);
    EXPECT_EQ(sound_hierarchy({unit_box_at({0, 0, 0}, 1, count - 1)}, parents).nodes.size(), 1u);
}

TEST(Hierarchy, OfOneNodeWithAHundredThousandChildrenIsShallow) {
    constexpr std::uint32_t count = 100'000;
    std::vector<std::uint32_t> parents{none};
    std::vector<Object> objects = scattered(count);
    for (std::uint32_t i = 0; i < count; ++i) {
        parents.push_back(0);
        objects[i].graph_node = i + 1;
    }
    EXPECT_LE(depth_of(sound_hierarchy(objects, parents)), 10u);
}

TEST(Hierarchy, DividesIdenticalBoxes) {
    const std::vector<Object> objects(10'000, unit_box_at({5, 5, 5}, 1'000));
    EXPECT_LE(depth_of(sound_hierarchy(objects, {})), 8u);
}

TEST(Hierarchy, TakesBoxesOfNoSizeAtTheEdgesOfDouble) {
    std::vector<Object> objects;
    for (const double x : {-1e308, 0.0, 1e-308, 1.0, 1e308})
        objects.push_back({{Vec3d{x, 0, 0}, Vec3d{x, 0, 0}}, 20'000, 0});
    EXPECT_GT(sound_hierarchy(objects, {}).nodes.size(), 5u);
}

TEST(Hierarchy, OneHugeObjectAmongSmallOnesMakesNoChain) {
    std::vector<Object> objects = scattered(20'000);
    objects[7] = {{{0, 0, 0}, {1e3, 1e2, 1e3}}, 1'000'000'000, 0};
    EXPECT_LE(depth_of(sound_hierarchy(objects, {})), 24u);
}

TEST(Hierarchy, AnyGraphGivesASoundOne) {
    Random random(7);
    for (int round = 0; round < 200; ++round) {
        std::vector<std::uint32_t> parents;
        const std::size_t nodes = 1 + random.next() % 300;
        for (std::size_t i = 0; i < nodes; ++i)
            parents.push_back(i == 0 || random.uniform() < 0.05 ? none : static_cast<std::uint32_t>(random.next() % i));
        std::vector<Object> objects = scattered(random.next() % 400, random.next());
        for (Object& object : objects) {
            object.graph_node = static_cast<std::uint32_t>(random.next() % nodes);
            if (random.uniform() < 0.1) object = {{}, 0, object.graph_node};
        }
        HierarchyOptions options;
        options.max_children = 2 + static_cast<std::uint32_t>(random.next() % 8);
        options.leaf_triangles = random.next() % 5'000;
        sound_hierarchy(objects, parents, options);
    }
}

}  // namespace
}  // namespace lodestream::scene
