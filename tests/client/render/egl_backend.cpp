#include <gtest/gtest.h>

#include <utility>

#include "client/render/gl_context.h"
#include "tests/client/render/backend.h"

namespace lodestream::testing {

struct Backend::Impl {
    render::GlContext context;
};

Backend::Backend() {
    auto context = render::create_headless_context();
    if (context)
        impl_ = std::make_unique<Impl>(Impl{*std::move(context)});
    else
        ADD_FAILURE() << context.error().message;
}

Backend::~Backend() = default;

std::vector<std::string> Backend::misuses() const {
    return {};
}

}  // namespace lodestream::testing
