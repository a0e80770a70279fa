#include "tests/client/render/backend.h"
#include "tests/client/render/fake/recording_gl.h"

namespace lodestream::testing {

struct Backend::Impl {
    RecordingGl gl;
};

Backend::Backend() : impl_(std::make_unique<Impl>()) {}

Backend::~Backend() = default;

std::vector<std::string> Backend::misuses() const {
    return impl_->gl.record().misuses;
}

}  // namespace lodestream::testing
