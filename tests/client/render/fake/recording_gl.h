// A recording fake of OpenGL ES 3. It defines the entry points that the renderer calls, so a program that is linked
// with it instead of with a driver's library draws without a driver. Nothing is rasterised: a picture has the colour
// that it was cleared with. What is drawn is recorded as the shaders would read it, vertex by vertex.
//
// Stricter than any driver: besides the errors that OpenGL demands it names every misuse that drivers bear in silence:
// reading beyond a buffer, a uniform or a texture that was never set, an object that is deleted, deleted twice or of
// another context, a name left behind.
#pragma once

#include <GLES3/gl32.h>

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "common/base/math.h"

namespace lodestream::testing {

// The driver that the fake stands for.
struct GlDriver {
    int version = 32;       // 32 is OpenGL ES 3.2
    GLint max_side = 4096;  // px, of renderbuffers and the viewport
    GLint max_texture_side = 4096;
    GLint max_samples = 4;
    GLfloat max_point_px = 255.0f;
    std::uint64_t memory_bytes = 1u << 30;  // of buffers, textures and renderbuffers; past it GL_OUT_OF_MEMORY
    std::string refused_shader{};           // a shader whose text holds this does not compile; empty: none
    bool links = true;
    bool completes_framebuffers = true;
};

// One draw call with all that it depends on.
struct GlDraw {
    GLenum mode = 0;
    GLsizei count = 0, instances = 1;
    std::map<std::string, std::vector<float>> uniforms;  // whole numbers as floats
    std::map<std::string, std::vector<Vec4f>> vertices;  // of each attribute, in the order in which they are read
    std::array<GLuint, 2> textures{};                    // of units 0 and 1
    bool blends = false, writes_depth = true, tests_depth = false, shades_samples = false;
    GLbitfield samples = ~0u;  // the mask, where it is enabled
    friend bool operator==(const GlDraw&, const GlDraw&) = default;
};

struct GlRecord {
    std::vector<GlDraw> draws;
    std::vector<std::string> misuses;         // in words; empty is right
    std::uint64_t uploads = 0;                // buffers and textures filled
    std::uint64_t bytes = 0, peak_bytes = 0;  // of the driver's memory that is in use
    std::uint64_t created = 0, deleted = 0;   // objects of every kind
};

class GlState;

// A context; current from its birth on.
class RecordingGl {
  public:
    explicit RecordingGl(const GlDriver& driver = {});
    RecordingGl(const RecordingGl&) = delete;
    RecordingGl& operator=(const RecordingGl&) = delete;
    ~RecordingGl();

    void make_current();
    GlDriver& driver();  // may change at any time
    GlRecord& record();

  private:
    std::unique_ptr<GlState> state_;
};

}  // namespace lodestream::testing
