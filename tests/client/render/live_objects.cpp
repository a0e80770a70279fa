#include <GLES3/gl3.h>

#include "tests/client/render/backend.h"

namespace lodestream::testing {
namespace {

constexpr GLuint last_name = 10'000;  // drivers count from 1 and take what became free; the fake counts by eights

std::uint64_t bytes_of(GLuint buffer) {
    GLint bytes = 0;
    glBindBuffer(GL_ARRAY_BUFFER, buffer);
    glGetBufferParameteriv(GL_ARRAY_BUFFER, GL_BUFFER_SIZE, &bytes);
    glBindBuffer(GL_ARRAY_BUFFER, 0);
    return static_cast<std::uint64_t>(bytes);
}

}  // namespace

LiveObjects live_objects() {
    LiveObjects live;
    for (GLuint name = 1; name <= last_name; ++name) {
        if (glIsBuffer(name)) {
            ++live.buffers;
            live.buffer_bytes += bytes_of(name);
        }
        live.textures += glIsTexture(name) ? 1 : 0;
        live.renderbuffers += glIsRenderbuffer(name) ? 1 : 0;
        live.framebuffers += glIsFramebuffer(name) ? 1 : 0;
        live.vertex_arrays += glIsVertexArray(name) ? 1 : 0;
        live.shaders += glIsShader(name) ? 1 : 0;
        live.programs += glIsProgram(name) ? 1 : 0;
    }
    return live;
}

}  // namespace lodestream::testing
