// A renderer with a context of its own for each case.
#pragma once

#include <gtest/gtest.h>

#include <optional>
#include <utility>

#include "client/render/gl_context.h"
#include "client/render/renderer.h"

namespace lodestream::testing {

class WithRenderer : public ::testing::Test {
  protected:
    void SetUp() override {
        auto made_context = render::create_headless_context();
        ASSERT_TRUE(made_context) << made_context.error().message;
        context.emplace(*std::move(made_context));
        auto made_renderer = render::Renderer::create();
        ASSERT_TRUE(made_renderer) << made_renderer.error().message;
        renderer.emplace(*std::move(made_renderer));
    }

    std::optional<render::GlContext> context;
    std::optional<render::Renderer> renderer;  // goes before its context
};

}  // namespace lodestream::testing
