#include "client/render/gl_context.h"

#include <gtest/gtest.h>

#include "client/render/renderer.h"

namespace lodestream::render {
namespace {

TEST(GlContext, IsOpenGlEs3WithoutADisplay) {
    const auto context = create_headless_context();
    ASSERT_TRUE(context) << context.error().message;
    EXPECT_NE(context->version().find("OpenGL ES 3"), std::string::npos) << context->version();
    EXPECT_FALSE(context->renderer().empty());
}

TEST(GlContext, TwoContextsDrawInTurn) {
    auto first = create_headless_context();
    ASSERT_TRUE(first) << first.error().message;
    auto first_renderer = Renderer::create();
    ASSERT_TRUE(first_renderer);
    {
        auto second = create_headless_context();
        ASSERT_TRUE(second) << second.error().message;
        auto second_renderer = Renderer::create();
        ASSERT_TRUE(second_renderer);
        ASSERT_TRUE(second_renderer->draw({{0, 0, 1}, {0, 0, 0}, 45, {0, 0, 1}}, {.width = 2, .height = 2}));
    }
    first->make_current();
    EXPECT_TRUE(first_renderer->draw({{0, 0, 1}, {0, 0, 0}, 45, {0, 0, 1}}, {.width = 2, .height = 2}));
}

TEST(Renderer, NeedsACurrentContext) {
    const auto renderer = Renderer::create();
    ASSERT_FALSE(renderer);
    EXPECT_EQ(renderer.error().code, ErrorCode::unavailable);
}

}  // namespace
}  // namespace lodestream::render
