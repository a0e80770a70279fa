#include "client/render/slices.h"

#include <GLES3/gl32.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <new>
#include <string>
#include <utility>

#include "client/render/gl_objects.h"
#include "client/render/programs.h"
#include "client/render/shaders.h"

namespace lodestream::render {
namespace {

constexpr GLuint background = 0;  // as a triangle's number + 1

// Three corners a triangle that no other shares: their place tells its number.
constexpr const char* slice_vertex_shader = R"(
precision highp float;
precision highp int;
layout(location = 0) in vec3 a_corner;  // px, as the depth
uniform vec3 u_picture;                 // its width and height in px, and the depth's end
flat out uint v_triangle;
out float v_depth;

void main() {
    gl_Position = vec4(2.0 * a_corner / u_picture - 1.0, 1.0);
    v_triangle = uint(gl_VertexID / 3);
    v_depth = a_corner.z;
}
)";

constexpr const char* slice_fragment_shader = R"(
precision highp float;
precision highp int;
flat in uint v_triangle;
in float v_depth;
uniform float u_slice_px;
uniform ivec2 u_slice;  // the one that is drawn, and the last one
out uint triangle;

void main() {
    if (clamp(int(floor(v_depth / u_slice_px)), 0, u_slice.y) != u_slice.x) discard;
    triangle = v_triangle + 1u;
}
)";

// Corners of the triangles that reach into each slice, one slice after the other.
struct Bins {
    std::vector<std::uint32_t> corners;
    std::vector<std::size_t> first;  // of each slice, and one past the last
};

std::array<std::uint32_t, 2> reach(const std::array<Vec3f, 3>& triangle, const points::ViewSize& size) {
    const auto [least, most] = std::minmax({triangle[0].z, triangle[1].z, triangle[2].z});
    // A pixel's depth is interpolated: it may be rounded out of the corners' by a little.
    constexpr double margin_px = 1e-3;
    const auto slice = [&](double depth) {
        return static_cast<std::uint32_t>(std::clamp(std::floor(depth / size.slice_px), 0.0, size.slices - 1.0));
    };
    return {slice(least - margin_px), slice(most + margin_px)};
}

Bins binned(const points::SlicedView& view) {
    Bins bins;
    bins.first.assign(view.size.slices + 1, 0);
    for (const auto& triangle : view.triangles) {
        const auto [low, high] = reach(triangle, view.size);
        for (std::uint32_t s = low; s <= high; ++s) bins.first[s + 1] += 3;
    }
    for (std::size_t s = 0; s < view.size.slices; ++s) bins.first[s + 1] += bins.first[s];
    bins.corners.resize(bins.first.back());
    std::vector<std::size_t> next(bins.first.begin(), bins.first.end() - 1);
    for (std::size_t t = 0; t < view.triangles.size(); ++t) {
        const auto [low, high] = reach(view.triangles[t], view.size);
        for (std::uint32_t s = low; s <= high; ++s)
            for (std::uint32_t k = 0; k < 3; ++k) bins.corners[next[s]++] = static_cast<std::uint32_t>(3 * t + k);
    }
    return bins;
}

Error no_memory(const points::ViewSize& size) {
    return fail(ErrorCode::limit_exceeded, "the graphics driver has no memory for slices of " +
                                               std::to_string(size.width) + "x" + std::to_string(size.height) + " px");
}

}  // namespace

struct SliceRenderer::Impl {
    GLuint program = 0, framebuffer = 0, numbers = 0, depth = 0, vertices = 0, corners = 0, indices = 0;
    GLint picture = -1, slice_px = -1, slice = -1, max_side = 0;

    Impl() = default;
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;
    ~Impl() {
        glDeleteProgram(program);
        glDeleteFramebuffers(1, &framebuffer);
        glDeleteRenderbuffers(1, &numbers);
        glDeleteRenderbuffers(1, &depth);
        glDeleteVertexArrays(1, &vertices);
        glDeleteBuffers(1, &corners);
        glDeleteBuffers(1, &indices);
    }

    Status create();
    bool prepare(const points::SlicedView& view, const Bins& bins);
    void draw_slice(GLsizei count, std::size_t first, bool from_front);
    std::vector<GLuint> read_back(const points::ViewSize& size);
    Result<std::vector<points::Seen>> draw(const points::SlicedView& view);
};

Status SliceRenderer::Impl::create() {
    if (!glGetString(GL_VERSION) || driver_version() < 30)
        return fail(ErrorCode::unavailable, "the current context is not OpenGL ES 3");
    const auto linked = link(SHADER_300, slice_vertex_shader, slice_fragment_shader);
    if (!linked) return linked.error();
    program = *linked;
    picture = glGetUniformLocation(program, "u_picture");
    slice_px = glGetUniformLocation(program, "u_slice_px");
    slice = glGetUniformLocation(program, "u_slice");
    glGetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &max_side);
    glGenFramebuffers(1, &framebuffer);
    glGenRenderbuffers(1, &numbers);
    glGenRenderbuffers(1, &depth);
    glGenVertexArrays(1, &vertices);
    glGenBuffers(1, &corners);
    glGenBuffers(1, &indices);
    return Nothing{};
}

// Leaves all bound that a slice is drawn with. False: the driver has no memory for it.
bool SliceRenderer::Impl::prepare(const points::SlicedView& view, const Bins& bins) {
    gl_failed();
    const auto width = static_cast<GLsizei>(view.size.width), height = static_cast<GLsizei>(view.size.height);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glBindRenderbuffer(GL_RENDERBUFFER, numbers);
    glRenderbufferStorage(GL_RENDERBUFFER, GL_R32UI, width, height);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, numbers);
    glBindRenderbuffer(GL_RENDERBUFFER, depth);
    glRenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT32F, width, height);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth);
    glViewport(0, 0, width, height);
    glBindVertexArray(vertices);
    glBindBuffer(GL_ARRAY_BUFFER, corners);
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(view.triangles.size_bytes()), view.triangles.data(),
                 GL_STREAM_DRAW);
    glEnableVertexAttribArray(0);
    glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(Vec3f), nullptr);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices);
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(bins.corners.size() * sizeof(std::uint32_t)),
                 bins.corners.data(), GL_STREAM_DRAW);
    glUseProgram(program);
    // Depths lie well inside the clip volume, their ends too.
    glUniform3f(picture, static_cast<float>(width), static_cast<float>(height),
                static_cast<float>(1.01 * view.size.slice_px * view.size.slices));
    glUniform1f(slice_px, static_cast<float>(view.size.slice_px));
    glDisable(GL_CULL_FACE);
    glDisable(GL_BLEND);
    glEnable(GL_DEPTH_TEST);
    glDepthMask(GL_TRUE);
    return !gl_failed() && glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
}

void SliceRenderer::Impl::draw_slice(GLsizei count, std::size_t first, bool from_front) {
    constexpr std::array<GLuint, 4> nothing{background, 0, 0, 0};
    const GLfloat farthest = from_front ? 1.0f : 0.0f;
    glClearBufferuiv(GL_COLOR, 0, nothing.data());
    glClearBufferfv(GL_DEPTH, 0, &farthest);
    glDepthFunc(from_front ? GL_LESS : GL_GREATER);
    glDrawElements(GL_TRIANGLES, count, GL_UNSIGNED_INT,
                   reinterpret_cast<const void*>(static_cast<std::uintptr_t>(first) * sizeof(std::uint32_t)));
}

// Four numbers a pixel, the first of which counts: what every driver of OpenGL ES 3 gives.
std::vector<GLuint> SliceRenderer::Impl::read_back(const points::ViewSize& size) {
    std::vector<GLuint> texels(std::size_t{size.width} * size.height * 4);
    glReadPixels(0, 0, static_cast<GLsizei>(size.width), static_cast<GLsizei>(size.height), GL_RGBA_INTEGER,
                 GL_UNSIGNED_INT, texels.data());
    return texels;
}

Result<std::vector<points::Seen>> SliceRenderer::Impl::draw(const points::SlicedView& view) {
    const auto side = static_cast<std::uint32_t>(max_side);
    if (view.size.width > side || view.size.height > side)
        return fail(ErrorCode::limit_exceeded, "slices are larger than the driver draws");
    if (view.triangles.size() > std::numeric_limits<std::uint32_t>::max() / 3)
        return fail(ErrorCode::limit_exceeded, "too many triangles to draw in slices");
    const Bins bins = binned(view);
    if (!prepare(view, bins)) return no_memory(view.size);
    std::vector<points::Seen> seen;
    for (std::uint32_t s = 0; s < view.size.slices; ++s) {
        const std::size_t first = bins.first[s], count = bins.first[s + 1] - first;
        if (count == 0) continue;
        glUniform2i(slice, static_cast<GLint>(s), static_cast<GLint>(view.size.slices) - 1);
        draw_slice(static_cast<GLsizei>(count), first, true);
        const std::vector<GLuint> front = read_back(view.size);
        draw_slice(static_cast<GLsizei>(count), first, false);
        const std::vector<GLuint> back = read_back(view.size);
        for (std::uint32_t pixel = 0; pixel < view.size.width * view.size.height; ++pixel) {
            const GLuint nearest = front[std::size_t{pixel} * 4], farthest = back[std::size_t{pixel} * 4];
            if (nearest != background) seen.push_back({pixel, nearest - 1});
            if (farthest != background && farthest != nearest) seen.push_back({pixel, farthest - 1});
        }
    }
    glBindVertexArray(0);
    glUseProgram(0);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    if (gl_failed()) return no_memory(view.size);
    return seen;
}

SliceRenderer::SliceRenderer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
SliceRenderer::SliceRenderer(SliceRenderer&&) noexcept = default;
SliceRenderer& SliceRenderer::operator=(SliceRenderer&&) noexcept = default;
SliceRenderer::~SliceRenderer() = default;

Result<SliceRenderer> SliceRenderer::create() {
    auto impl = std::make_unique<Impl>();
    if (auto made = impl->create(); !made) return made.error();
    return SliceRenderer(std::move(impl));
}

Result<std::vector<points::Seen>> SliceRenderer::draw(const points::SlicedView& view) {
    try {
        return impl_->draw(view);
    } catch (const std::bad_alloc&) {
        return fail(ErrorCode::limit_exceeded, "not enough memory for slices");
    }
}

}  // namespace lodestream::render
