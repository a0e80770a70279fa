#include "client/render/gl_objects.h"

namespace lodestream::render {
namespace {

void attribute(GLuint location, GLint components, GLenum type, bool normalized, std::size_t stride,
               std::size_t offset) {
    glEnableVertexAttribArray(location);
    glVertexAttribPointer(location, components, type, normalized ? GL_TRUE : GL_FALSE, static_cast<GLsizei>(stride),
                          reinterpret_cast<const void*>(offset));
}

template <class T>
std::uint64_t add_buffer(VertexArray& array, GLenum target, const std::vector<T>& data) {
    GLuint& buffer = array.buffers.emplace_back(0);
    glGenBuffers(1, &buffer);
    glBindBuffer(target, buffer);
    glBufferData(target, static_cast<GLsizeiptr>(data.size() * sizeof(T)), data.data(), GL_STATIC_DRAW);
    return data.size() * sizeof(T);
}

GLuint make_renderbuffer(const Target& target, GLenum format) {
    GLuint id = 0;
    glGenRenderbuffers(1, &id);
    glBindRenderbuffer(GL_RENDERBUFFER, id);
    glRenderbufferStorageMultisample(GL_RENDERBUFFER, target.samples > 1 ? static_cast<GLsizei>(target.samples) : 0,
                                     format, static_cast<GLsizei>(target.width), static_cast<GLsizei>(target.height));
    return id;
}

}  // namespace

int driver_version() {
    GLint major = 0, minor = 0;
    glGetIntegerv(GL_MAJOR_VERSION, &major);
    glGetIntegerv(GL_MINOR_VERSION, &minor);
    return major * 10 + minor;
}

bool gl_failed() {
    bool failed = false;
    while (glGetError() != GL_NO_ERROR) failed = true;
    return failed;
}

GLuint make_texture(std::uint32_t width, std::uint32_t height, const std::uint8_t* rgba) {
    GLuint texture = 0;
    glGenTextures(1, &texture);
    glBindTexture(GL_TEXTURE_2D, texture);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_SRGB8_ALPHA8, static_cast<GLsizei>(width), static_cast<GLsizei>(height), 0,
                 GL_RGBA, GL_UNSIGNED_BYTE, rgba);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glGenerateMipmap(GL_TEXTURE_2D);
    return texture;
}

GLint wrap_mode(mesh::Wrap wrap) {
    switch (wrap) {
        case mesh::Wrap::clamp_to_edge:
            return GL_CLAMP_TO_EDGE;
        case mesh::Wrap::mirrored_repeat:
            return GL_MIRRORED_REPEAT;
        case mesh::Wrap::repeat:
            break;
    }
    return GL_REPEAT;
}

std::uint64_t fill(VertexArray& array, const Streams& streams, Style style, bool is_textured) {
    constexpr std::size_t corner = sizeof(Vec3f);
    glGenVertexArrays(1, &array.id);
    glBindVertexArray(array.id);
    std::uint64_t bytes = add_buffer(array, GL_ARRAY_BUFFER, streams.positions);
    attribute(location_position, 3, GL_FLOAT, false, corner, 0);
    if (style == Style::flat) {
        bytes += add_buffer(array, GL_ARRAY_BUFFER, streams.first_corners);
        attribute(location_first, 3, GL_FLOAT, false, corner, 0);
        bytes += add_buffer(array, GL_ARRAY_BUFFER, streams.previous_corners);
        attribute(location_normal_or_previous, 3, GL_FLOAT, false, corner, 0);
    } else if (!streams.normals.empty()) {
        bytes += add_buffer(array, GL_ARRAY_BUFFER, streams.normals);
        attribute(location_normal_or_previous, 3, GL_FLOAT, false, corner, 0);
    }
    if (style != Style::points) bytes += add_buffer(array, GL_ELEMENT_ARRAY_BUFFER, streams.indices);
    if (!streams.colors.empty()) {
        bytes += add_buffer(array, GL_ARRAY_BUFFER, streams.colors);
        attribute(location_color, 4, GL_UNSIGNED_BYTE, true, sizeof(Rgba8), 0);
    }
    if (is_textured && !streams.texture_coordinates.empty()) {
        bytes += add_buffer(array, GL_ARRAY_BUFFER, streams.texture_coordinates);
        attribute(location_texture_coordinate, 2, GL_FLOAT, false, sizeof(Vec2f), 0);
    }
    glBindVertexArray(0);
    return bytes;
}

void release(VertexArray& array) {
    glDeleteBuffers(static_cast<GLsizei>(array.buffers.size()), array.buffers.data());
    glDeleteVertexArrays(1, &array.id);
    array = {};
}

void release(Target& target) {
    glDeleteFramebuffers(1, &target.framebuffer);
    glDeleteRenderbuffers(1, &target.color);
    glDeleteRenderbuffers(1, &target.depth);
    target = {};
}

bool resize(Target& target, std::uint32_t width, std::uint32_t height, std::uint32_t samples, bool with_depth) {
    if (target.width == width && target.height == height && target.samples == samples) return true;
    release(target);
    gl_failed();
    target = {width, height, samples, 0, 0, 0};
    target.color = make_renderbuffer(target, GL_SRGB8_ALPHA8);
    if (with_depth) target.depth = make_renderbuffer(target, GL_DEPTH_COMPONENT24);
    glGenFramebuffers(1, &target.framebuffer);
    glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, target.color);
    if (with_depth) glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, target.depth);
    const bool complete = !gl_failed() && glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
    if (!complete) release(target);
    return complete;
}

}  // namespace lodestream::render
