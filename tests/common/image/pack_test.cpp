#include "common/image/pack.h"

#include <gtest/gtest.h>

#include <random>

namespace lodestream::image {
namespace {

TEST(Pack, NothingOverlapsAndLittleIsWasted) {
    std::mt19937 random(5);
    std::uniform_int_distribution<std::uint32_t> side(1, 40);
    std::vector<Rectangle> rectangles(400);
    double area = 0.0;
    for (Rectangle& r : rectangles) {
        r.width = side(random);
        r.height = side(random);
        area += r.width * r.height;
    }
    const PackedSize size = pack(rectangles);
    std::vector<int> owner(std::size_t{size.width} * size.height, -1);
    for (int i = 0; i < 400; ++i) {
        const Rectangle& r = rectangles[static_cast<std::size_t>(i)];
        for (std::uint32_t y = r.y; y < r.y + r.height; ++y)
            for (std::uint32_t x = r.x; x < r.x + r.width; ++x) {
                ASSERT_LT(x, size.width);
                ASSERT_LT(y, size.height);
                EXPECT_EQ(owner[std::size_t{y} * size.width + x], -1);
                owner[std::size_t{y} * size.width + x] = i;
            }
    }
    EXPECT_LT(static_cast<double>(owner.size()), 1.2 * area);
}

TEST(Pack, OneNoneAndVeryLong) {
    std::vector<Rectangle> none, one{{7, 3}}, lengthy{{2'048, 1}, {1, 2'048}, {2'048, 1}};
    EXPECT_EQ(pack(none).height, 0u);
    EXPECT_EQ(pack(one).width, 7u);
    EXPECT_EQ(one[0].x, 0u);
    const PackedSize size = pack(lengthy);
    EXPECT_GE(size.width, 2'048u);
    EXPECT_LE(size.height, 2'051u);
}

}  // namespace
}  // namespace lodestream::image
