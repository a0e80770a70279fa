// Where drawing happens: an OpenGL ES 3 context without a window or display server. The renderer needs a current ES 3
// context and does not know this file; a windowed program may bring its own.
#pragma once

#include <memory>
#include <string>

#include "common/base/result.h"

namespace lodestream::render {

// Owns an EGL context that is current on the thread that made it. One thread only.
class GlContext {
  public:
    GlContext(GlContext&&) noexcept;
    GlContext& operator=(GlContext&&) noexcept;
    ~GlContext();

    void make_current();                  // after another context was current on this thread
    const std::string& renderer() const;  // "llvmpipe (LLVM 15.0.6, 256 bits)"
    const std::string& version() const;   // "OpenGL ES 3.2 Mesa 22.3.6"
    bool software() const;                // drawn by the CPU: no GPU was found

  private:
    struct Impl;
    explicit GlContext(std::unique_ptr<Impl> impl);
    friend Result<GlContext> create_headless_context();
    std::unique_ptr<Impl> impl_;
};

// Tries every GPU's EGL device, then Mesa's surfaceless platform, which draws in software where there is no GPU.
// Software's threads are spread over the processors (rasterizer_threads.h).
// Errors: unavailable (no EGL driver, or none with OpenGL ES 3).
Result<GlContext> create_headless_context();

}  // namespace lodestream::render
