// The objects that the renderer keeps in OpenGL ES 3 beside its programs: textures, vertex arrays and what is drawn
// into. Private to this folder. All are of the current context, and their owner releases them.
#pragma once

#include <GLES3/gl32.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "client/render/scene.h"
#include "common/mesh/mesh.h"

namespace lodestream::render {

// Of OpenGL ES: 32 is 3.2.
int driver_version();

// Since the last call; forgets errors from before, which are another caller's.
bool gl_failed();

enum Location : GLuint {
    location_position,
    location_color,
    location_texture_coordinate,
    location_normal_or_previous,
    location_first
};

// RGBA, sRGB-coded, with mip levels.
GLuint make_texture(std::uint32_t width, std::uint32_t height, const std::uint8_t* rgba);
GLint wrap_mode(mesh::Wrap wrap);

struct VertexArray {
    GLuint id = 0;
    std::vector<GLuint> buffers;
};

enum class Style : std::uint8_t { gouraud, flat, points, quads };  // the last two of discs, over the same array

// With texture coordinates only where they are read. Returns the bytes that the buffers take.
std::uint64_t fill(VertexArray& array, const Streams& streams, Style style, bool is_textured);
void release(VertexArray& array);

struct Target {
    std::uint32_t width = 0, height = 0, samples = 0;
    GLuint framebuffer = 0, color = 0, depth = 0;
};

// Nothing where it has that size. `samples` = 1 without depth is what a multisampled picture is resolved into. False:
// the driver has no memory for it.
bool resize(Target& target, std::uint32_t width, std::uint32_t height, std::uint32_t samples, bool with_depth);
void release(Target& target);

}  // namespace lodestream::render
