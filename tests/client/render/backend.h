// What the suite draws with. A program links one of the two that there are: egl_backend.cpp, or fake/fake_backend.cpp,
// where nothing but the entry points' recording fake answers.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace lodestream::testing {

// A context, current from its birth on.
class Backend {
  public:
    Backend();
    Backend(const Backend&) = delete;
    Backend& operator=(const Backend&) = delete;
    ~Backend();

    std::vector<std::string> misuses() const;  // of OpenGL until now, in words; a real driver names none

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

// Objects of the current context, by asking it for every name.
struct LiveObjects {
    int buffers = 0, textures = 0, renderbuffers = 0, framebuffers = 0, vertex_arrays = 0, shaders = 0, programs = 0;
    std::uint64_t buffer_bytes = 0;
    friend bool operator==(const LiveObjects&, const LiveObjects&) = default;
};
LiveObjects live_objects();

}  // namespace lodestream::testing
