#include "common/scene/lod_tree.h"

#include <gtest/gtest.h>

#include "tests/common/scene/trees.h"

namespace lodestream::scene {
namespace {

LodTree sound_tree() {
    Random random(1);
    return testing::made_tree(50, random);
}

TEST(LodTree, ValidatesWhatKeepsItsLaws) {
    EXPECT_TRUE(validate(sound_tree()));
    EXPECT_TRUE(validate(LodTree(1)));
    LodTree by_and_by(6);  // children of a later node may lie before those of an earlier one
    by_and_by[0].first_child = 1;
    by_and_by[1].first_child = 4;
    by_and_by[2].first_child = 3;
    for (const auto& [node, parent] : {std::pair{1u, 0u}, {2u, 0u}, {3u, 2u}, {4u, 1u}, {5u, 1u}}) {
        by_and_by[node].parent = parent;
        ++by_and_by[parent].child_count;
    }
    EXPECT_TRUE(validate(by_and_by));
    by_and_by[5].parent = 2;
    EXPECT_FALSE(validate(by_and_by));
}

TEST(LodTree, RefusesWhatDoesNot) {
    const auto refused = [](auto change) {
        LodTree tree = sound_tree();
        change(tree);
        return !validate(tree);
    };
    EXPECT_TRUE(refused([](LodTree& t) { t.clear(); }));
    EXPECT_TRUE(refused([](LodTree& t) { t[0].parent = 1; }));
    EXPECT_TRUE(refused([](LodTree& t) { t[1].parent = 2; }));
    EXPECT_TRUE(refused([](LodTree& t) { t[0].first_child = 0; }));
    EXPECT_TRUE(refused([](LodTree& t) { t[0].child_count = none; }));
    EXPECT_TRUE(refused([](LodTree& t) { t.back().child_count = 1, t.back().first_child = 0; }));
    EXPECT_TRUE(refused([](LodTree& t) { t.emplace_back(); }));
    EXPECT_TRUE(refused([](LodTree& t) { t[1].error = 2.0 * t[0].error; }));
    EXPECT_TRUE(refused([](LodTree& t) { t[1].error = NAN; }));
    EXPECT_TRUE(refused([](LodTree& t) { t[1].box.max.x = INFINITY; }));
    EXPECT_TRUE(refused([](LodTree& t) { t[1].box.max.x = t[0].box.max.x + 1.0; }));
    EXPECT_TRUE(refused([](LodTree& t) { t[3].triangles = t[4].triangles = max_tree_triangles; }));
}

}  // namespace
}  // namespace lodestream::scene
