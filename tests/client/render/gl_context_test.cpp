#include "client/render/gl_context.h"

#include <gtest/gtest.h>
#include <sched.h>

#include <filesystem>
#include <fstream>
#include <set>
#include <string>

#include "client/render/rasterizer_threads.h"
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

TEST(GlContext, NoTwoRasterizerThreadsShareAProcessor) {
    const auto context = create_headless_context();
    ASSERT_TRUE(context) << context.error().message;
    const std::size_t placed = spread_rasterizer_threads();  // again: changes nothing
    if (placed == 0) GTEST_SKIP() << "one thread for each processor is llvmpipe's; this is " << context->renderer();
    std::set<int> processors;
    std::size_t alone = 0;
    for (const auto& thread : std::filesystem::directory_iterator("/proc/self/task")) {
        std::string name;
        std::ifstream(thread.path() / "comm") >> name;
        if (!name.starts_with("llvmpipe-")) continue;
        cpu_set_t may_run_on;
        ASSERT_EQ(sched_getaffinity(std::stoi(thread.path().filename().string()), sizeof may_run_on, &may_run_on), 0);
        alone += CPU_COUNT(&may_run_on) == 1 ? 1 : 0;
        for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu)
            if (CPU_ISSET(cpu, &may_run_on)) processors.insert(cpu);
    }
    EXPECT_EQ(alone, placed);
    EXPECT_EQ(processors.size(), placed);
}

TEST(Renderer, NeedsACurrentContext) {
    const auto renderer = Renderer::create();
    ASSERT_FALSE(renderer);
    EXPECT_EQ(renderer.error().code, ErrorCode::unavailable);
}

}  // namespace
}  // namespace lodestream::render
