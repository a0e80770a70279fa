#include "client/render/renderer.h"

#include <GLES3/gl32.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <map>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "client/render/gl_objects.h"
#include "client/render/programs.h"
#include "client/render/scene.h"
#include "client/render/shaders.h"

namespace lodestream::render {
namespace {

constexpr double largest_disc_radius = 1e6;  // of the cloud's own; keeps what is worked out from it finite
constexpr float largest_quad_px = 1e6f;      // what is larger fills the picture
constexpr double least_cut_px = 4.0;         // smaller discs with their centre outside the picture may be left out

// Of a cloud, in the frame at hand.
struct Discs {
    GLsizei points = 0;
    float radius = 0.0f;  // scene coordinates
    bool as_quads = false;
};

// What comes and goes together: an uploaded level, or a part of a scene.
struct Group {
    std::vector<mesh::Material> materials;
    std::vector<GLuint> textures;  // one an image; 0 where it could not be decoded
    UploadStatistics uploaded;
    Sphere sphere;  // scene coordinates
    Discs discs;    // of a part of points
    // Of the frame at hand.
    bool is_shown = true;
    Share share;
};

bool is_whole(const Share& share) {
    return share.from <= 0.0 && share.to >= 1.0;
}

Share both(const Share& a, const Share& b) {
    return {std::max(a.from, b.from), std::min(a.to, b.to)};
}

bool is_valid(const Share& share) {
    return share.from >= 0.0 && share.to <= 1.0;  // not NaN
}

// What one draw call needs.
struct Batch {
    const Group* group = nullptr;
    Style style = Style::gouraud;
    Look look;
    std::uint32_t material = 0;
    VertexArray vertices;
    GLsizei first = 0, corners = 0;  // the range of the indices, or the points
    Vec3d center{0.0};
    std::shared_ptr<const std::vector<std::uint32_t>> places;  // of a movable level's triangles in its order; else null
};

// What a frame sent to the GPU.
struct Sent {
    std::uint64_t triangles = 0, points = 0;
    std::uint32_t draw_calls = 0;
};

// 0 where there is none.
GLuint texture_of(const mesh::TextureReference& reference, const Group& group) {
    return valid_image(reference, group.textures.size()) ? group.textures[static_cast<std::size_t>(reference.image)]
                                                         : 0;
}

bool is_blended(const Batch& batch) {
    return batch.group->materials[batch.material].alpha_mode == mesh::AlphaMode::blend;
}

Error out_of_memory(const std::string& what) {
    return fail(ErrorCode::limit_exceeded, "the graphics driver has no memory for " + what);
}

double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

// OpenGL's rows run upwards.
void flip_rows(Image& image) {
    const std::size_t row = std::size_t{image.width} * 4;
    for (std::size_t y = 0; y < image.height / 2; ++y) {
        const auto top = image.rgba.begin() + static_cast<std::ptrdiff_t>(y * row);
        const auto bottom = image.rgba.begin() + static_cast<std::ptrdiff_t>((image.height - 1 - y) * row);
        std::swap_ranges(top, top + static_cast<std::ptrdiff_t>(row), bottom);
    }
}

}  // namespace

struct Renderer::Impl {
    Programs programs;
    bool has_sample_shading = false;  // OpenGL ES 3.2
    float max_point_px = 1.0f;
    GLint max_side = 0, max_driver_samples = 1, max_texture_side = 0;
    Target target, resolved;

    std::vector<Batch> batches;  // opaque and masked by material, then blended ones
    Group level;
    std::optional<Box> scene_box;          // of the parts
    std::map<std::uint32_t, Group> parts;  // of the scene
    std::uint32_t next_part = 0;
    Placement placement;
    Vec3d origin{0.0};
    std::vector<points::Level> levels;  // of the cloud, model units
    std::vector<Camera> exposures;      // of the frame at hand, the drawn view last
    struct Shown {
        Vec3f offset{0.0f};  // scene coordinates
        Discs discs;
        Share share;
    };
    std::vector<Shown> shown;  // the instances of the frame at hand that its picture may show
    Sent sent;                 // of the frame at hand

    Impl() = default;
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;
    ~Impl() {
        clear();
        release(target);
        release(resolved);
    }

    Status create();
    void clear();
    void release_textures(Group& group) const;
    std::vector<std::string> begin_upload(const codec::Decoded& content);
    Result<Batch*> add_batch(Group& group, std::uint32_t material, Style style, const Streams& streams);
    Result<Batch*> add_batch(const codec::Primitive& primitive, Style style, std::size_t images);
    void add_discs(Group& group, const Streams& streams);
    void sort_batches();
    Result<UploadStatistics> end_upload(std::vector<std::string> warnings);
    Status begin_scene(const Box& box);
    Result<std::uint32_t> add(const Part& part);
    void remove(std::uint32_t part);
    Result<UploadStatistics> upload(const codec::Decoded& content);
    Result<UploadStatistics> upload(const MovableLevel& level);
    Result<UploadStatistics> upload(const codec::Points& content);
    void move_split(std::uint64_t border);
    Status check(const DrawOptions& options) const;
    Status prepare_targets(const DrawOptions& options);
    double disc_radius(std::uint64_t points) const;
    std::uint64_t points_worth_drawing(const Sphere& sphere) const;
    bool may_see(const Sphere& sphere) const;
    void show(const DrawOptions& options, const std::vector<Sphere>& spheres);
    Status show_parts(const DrawOptions& options);
    void set_lights(const Program& program, const std::vector<Vec4f>& lights, const shading::Phong& phong) const;
    void set_camera(const Program& program, const Camera& camera) const;
    void bind_texture(GLenum unit, const mesh::TextureReference& reference, const Group& group) const;
    void set_material(const Program& program, const mesh::Material& material, const Group& group) const;
    void set_share(const Program& program, const Share& share) const;
    bool is_drawn(const Shown& instance, const Batch& batch, Style style, bool fades) const;
    void draw_batch(const Program& program, const Batch& batch, Style style, bool fades);
    const Discs& discs_of(const Shown& instance, const Batch& batch) const;
    void draw_discs(const Program& program, const Discs& discs);
    Status expose(const shading::View& view, const DrawOptions& options, const Sphere& scene);
    void draw_exposures(const Program& program, const Batch& batch, Style style, bool fades);
    void draw_batch_as(Style style, const Batch& batch, bool fades);
    bool needs_quads(const Sphere& centers, double radius) const;
    void sort_blended();
    void draw_frame(const std::vector<Vec4f>& lights, const DrawOptions& options);
    Image read_back(const DrawOptions& options) const;
};

Status Renderer::Impl::create() {
    if (!glGetString(GL_VERSION)) return fail(ErrorCode::unavailable, "no OpenGL ES 3 context is current");
    if (driver_version() < 30) return fail(ErrorCode::unavailable, "the current context is not OpenGL ES 3");
    gl_failed();
    has_sample_shading = driver_version() >= 32;
    for (const Style style : {Style::gouraud, Style::flat, Style::points, Style::quads})
        if (auto linked = programs.link(style, {}); !linked) return linked;
    GLint renderbuffer_side = 0;
    std::array<GLint, 2> viewport_side{};
    glGetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &renderbuffer_side);
    glGetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport_side.data());
    glGetIntegerv(GL_MAX_SAMPLES, &max_driver_samples);
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &max_texture_side);
    std::array<GLfloat, 2> point_px{};
    glGetFloatv(GL_ALIASED_POINT_SIZE_RANGE, point_px.data());
    max_point_px = std::max(point_px[1] - 1.0f, 1.0f);  // leaves room for what the shader may add
    if (has_sample_shading) glMinSampleShading(1.0f);
    max_side = std::min({renderbuffer_side, viewport_side[0], viewport_side[1], static_cast<GLint>(image::max_side)});
    if (gl_failed()) return out_of_memory("the shaders");
    return Nothing{};
}

void Renderer::Impl::release_textures(Group& group) const {
    glDeleteTextures(static_cast<GLsizei>(group.textures.size()), group.textures.data());  // skips 0
    group.textures.clear();
}

void Renderer::Impl::clear() {
    for (Batch& batch : batches) release(batch.vertices);
    release_textures(level);
    for (auto& [id, part] : parts) release_textures(part);
    batches.clear();
    parts.clear();
    scene_box.reset();
    level = {};
    levels.clear();
    placement = {};
    origin = Vec3d{0.0};
}

// Everything but the geometry, in place of the level before.
std::vector<std::string> Renderer::Impl::begin_upload(const codec::Decoded& content) {
    clear();
    gl_failed();
    placement = place(content);
    origin = content.origin;
    level.materials = content.materials;
    level.textures.assign(content.images.size(), 0);
    return decode_shown(content.images, content.materials, static_cast<std::uint32_t>(max_texture_side),
                        [&](std::size_t i, Image&& image) {
                            level.textures[i] = make_texture(image.width, image.height, image.rgba.data());
                            level.uploaded.texture_bytes += image.rgba.size();
                        });
}

Result<Batch*> Renderer::Impl::add_batch(Group& group, std::uint32_t material, Style style, const Streams& streams) {
    const mesh::Material& looks = group.materials[material];
    const Look look{!streams.colors.empty(), texture_of(looks.base_color_texture, group) != 0,
                    texture_of(looks.emissive_texture, group) != 0, looks.alpha_mode == mesh::AlphaMode::mask};
    if (auto linked = programs.link(style, look); !linked) return linked.error();
    Batch& batch = batches.emplace_back();
    batch.group = &group;
    batch.style = style;
    batch.look = look;
    batch.material = material;
    batch.corners = static_cast<GLsizei>(streams.indices.size());
    batch.center = streams.bounds.center();
    group.uploaded.geometry_bytes += fill(batch.vertices, streams, style, look.is_textured());
    (style == Style::flat ? group.uploaded.flat_vertices : group.uploaded.gouraud_vertices) += streams.positions.size();
    return &batch;
}

Result<Batch*> Renderer::Impl::add_batch(const codec::Primitive& primitive, Style style, std::size_t images) {
    const bool textured = is_textured(level.materials[primitive.material], images);
    return add_batch(level, primitive.material, style,
                     style == Style::flat ? flat_streams(primitive.mesh, placement, textured)
                                          : gouraud_streams(primitive.mesh, placement, textured));
}

void Renderer::Impl::add_discs(Group& group, const Streams& streams) {
    group.uploaded.points = streams.positions.size();
    if (streams.positions.empty()) return;
    Batch& batch = batches.emplace_back();
    batch.group = &group;
    batch.style = Style::points;
    batch.corners = static_cast<GLsizei>(streams.positions.size());
    batch.center = streams.bounds.center();
    group.uploaded.geometry_bytes += fill(batch.vertices, streams, batch.style, false);
}

void Renderer::Impl::sort_batches() {
    std::stable_sort(batches.begin(), batches.end(), [](const Batch& a, const Batch& b) {
        return std::tuple(is_blended(a), a.style, a.material) < std::tuple(is_blended(b), b.style, b.material);
    });
}

Result<UploadStatistics> Renderer::Impl::end_upload(std::vector<std::string> warnings) {
    if (gl_failed()) return out_of_memory(std::to_string(level.uploaded.triangles) + " triangles");
    sort_batches();
    Result<UploadStatistics> result(level.uploaded);
    result.warnings = std::move(warnings);
    return result;
}

Result<UploadStatistics> Renderer::Impl::upload(const codec::Decoded& content) {
    if (auto sound = check_drawable(content); !sound) return sound.error();
    auto warnings = begin_upload(content);
    for (const codec::Primitive& primitive : content.primitives) {
        const std::size_t triangles = primitive.mesh.triangles.size();
        if (triangles == 0) continue;
        const bool is_flat = primitive.shading == codec::Shading::flat;
        const auto added = add_batch(primitive, is_flat ? Style::flat : Style::gouraud, content.images.size());
        if (!added) return added.error();
        level.uploaded.triangles += triangles;
        if (!is_flat) level.uploaded.gouraud_triangles += triangles;
    }
    return end_upload(std::move(warnings));
}

Result<UploadStatistics> Renderer::Impl::upload(const MovableLevel& movable) {
    if (auto sound = check_drawable(movable.content); !sound) return sound.error();
    if (movable.places.size() != movable.content.primitives.size())
        return invalid_input("a movable level needs the places of each primitive's triangles");
    auto warnings = begin_upload(movable.content);
    for (std::size_t i = 0; i < movable.content.primitives.size(); ++i) {
        const codec::Primitive& primitive = movable.content.primitives[i];
        if (primitive.mesh.triangles.size() != movable.places[i].size() || primitive.shading == codec::Shading::flat)
            return invalid_input("a movable level has Gouraud primitives and a place for each of their triangles");
        if (movable.places[i].empty()) continue;
        const auto places = std::make_shared<const std::vector<std::uint32_t>>(movable.places[i]);
        for (const Style style : {Style::gouraud, Style::flat}) {
            const auto added = add_batch(primitive, style, movable.content.images.size());
            if (!added) return added.error();
            (*added)->places = places;
        }
        level.uploaded.triangles += places->size();
        level.uploaded.gouraud_triangles += places->size();
    }
    move_split(level.uploaded.triangles);
    return end_upload(std::move(warnings));
}

Result<UploadStatistics> Renderer::Impl::upload(const codec::Points& content) {
    if (auto sound = check_drawable(content); !sound) return sound.error();
    clear();
    gl_failed();
    placement = place(content);
    origin = content.origin;
    levels = content.levels;
    level.materials.emplace_back().base_color = content.base_color;
    add_discs(level, disc_streams(content.cloud, placement));
    if (gl_failed()) return out_of_memory(std::to_string(level.uploaded.points) + " points");
    return level.uploaded;
}

Status Renderer::Impl::begin_scene(const Box& box) {
    clear();
    if (box.empty() || !std::isfinite(box.radius())) return invalid_input("a scene needs a finite box");
    placement = place(box);
    scene_box = box;
    return Nothing{};
}

Result<std::uint32_t> Renderer::Impl::add(const Part& part) {
    const PreparedPart* prepared = part.prepared.get();
    if (!prepared || !scene_box || prepared->scene.min != scene_box->min || prepared->scene.max != scene_box->max)
        return invalid_input("a part was not prepared for the scene that was begun");
    gl_failed();
    const std::uint32_t id = next_part;
    Group& group = parts[id];
    ++next_part;
    group.materials = prepared->materials;
    group.sphere = prepared->sphere;
    std::vector<std::string> warnings;
    for (const Image& image : prepared->images) {
        group.textures.push_back(0);
        if (image.rgba.empty()) continue;
        if (std::max(image.width, image.height) > static_cast<std::uint32_t>(max_texture_side))
            warnings.push_back("an image is drawn white: larger than the driver allows");
        else
            group.textures.back() = make_texture(image.width, image.height, image.rgba.data());
    }
    for (const PreparedPrimitive& primitive : prepared->primitives) {
        const Style style = primitive.is_flat ? Style::flat : Style::gouraud;
        if (const auto added = add_batch(group, primitive.material, style, primitive.streams); !added) {
            remove(id);
            return added.error();
        }
        group.uploaded.triangles += primitive.triangles;
    }
    add_discs(group, prepared->discs.streams);
    group.discs = {static_cast<GLsizei>(group.uploaded.points),
                   static_cast<float>(std::min(prepared->discs.radius, largest_disc_radius))};
    if (gl_failed()) {
        remove(id);
        return out_of_memory(std::to_string(part.triangles) + " triangles and " + std::to_string(part.points) +
                             " points");
    }
    sort_batches();
    Result<std::uint32_t> result(id);
    result.warnings = std::move(warnings);
    return result;
}

void Renderer::Impl::remove(std::uint32_t part) {
    const auto found = parts.find(part);
    if (found == parts.end()) return;
    const auto is_of_part = [&](const Batch& batch) { return batch.group == &found->second; };
    for (Batch& batch : batches)
        if (is_of_part(batch)) release(batch.vertices);
    std::erase_if(batches, is_of_part);
    release_textures(found->second);
    parts.erase(found);
}

void Renderer::Impl::move_split(std::uint64_t border) {
    for (Batch& batch : batches) {
        if (!batch.places) continue;
        const auto first_flat = std::lower_bound(batch.places->begin(), batch.places->end(), border);
        const auto smooth = static_cast<GLsizei>(3 * (first_flat - batch.places->begin()));
        const auto all = static_cast<GLsizei>(3 * batch.places->size());
        const bool is_flat = batch.style == Style::flat;
        batch.first = is_flat ? smooth : 0;
        batch.corners = is_flat ? all - smooth : smooth;
    }
}

Status Renderer::Impl::check(const DrawOptions& options) const {
    if (options.width == 0 || options.height == 0)
        return invalid_input("a picture needs a width and a height of at least 1 px");
    const auto side = static_cast<std::uint32_t>(max_side);
    if (options.width > side || options.height > side ||
        std::uint64_t{options.width} * options.height > image::max_pixels)
        return fail(ErrorCode::limit_exceeded, "a picture of " + std::to_string(options.width) + "x" +
                                                   std::to_string(options.height) + " px is too large to draw");
    if (options.samples == 0 || options.samples > max_samples) return invalid_input("samples must be 1 to 8");
    if (options.frames == 0) return invalid_input("frames must be at least 1");
    if (options.lights.size() > max_lights)
        return fail(ErrorCode::limit_exceeded, "at most " + std::to_string(max_lights) + " lights");
    for (const Instance& instance : options.instances) {
        if (!all_finite(instance.offset)) return invalid_input("an instance needs a finite offset");
        if (!is_valid(instance.share)) return invalid_input("an instance's share is not in [0, 1]");
    }
    for (const Light& light : options.lights)
        if (!all_finite(light.direction) || light.direction == Vec3d{0.0} || !(light.intensity >= 0.0) ||
            !std::isfinite(light.intensity))
            return invalid_input("a light needs a finite direction of some length and an intensity of at least 0");
    return Nothing{};
}

Status Renderer::Impl::prepare_targets(const DrawOptions& options) {
    const auto samples = std::min(options.samples, static_cast<std::uint32_t>(std::max(max_driver_samples, 1)));
    const bool ready = resize(target, options.width, options.height, samples, true) &&
                       (samples == 1 || resize(resolved, options.width, options.height, 1, false));
    if (!ready)
        return out_of_memory("a picture of " + std::to_string(options.width) + "x" + std::to_string(options.height));
    return Nothing{};
}

void Renderer::Impl::set_camera(const Program& program, const Camera& camera) const {
    const float width = static_cast<float>(target.width), height = static_cast<float>(target.height);
    glUniformMatrix4fv(program.clip_from_scene, 1, GL_FALSE, &camera.clip_from_scene[0][0]);
    glUniform3f(program.eye, camera.eye.x, camera.eye.y, camera.eye.z);
    if (!is_of_discs(program)) return;
    glUniformMatrix3fv(program.view_from_scene, 1, GL_FALSE, &camera.view_from_scene[0][0]);
    glUniform3f(program.picture, 0.5f * width, 0.5f * height, height * static_cast<float>(camera.heights_per_unit));
}

void Renderer::Impl::set_lights(const Program& program, const std::vector<Vec4f>& lights,
                                const shading::Phong& phong) const {
    glUniform4fv(program.lights, static_cast<GLsizei>(lights.size()), &lights[0][0]);
    glUniform1i(program.light_count, static_cast<GLint>(lights.size()));
    glUniform4f(program.phong, static_cast<float>(phong.ambient), static_cast<float>(phong.diffuse),
                static_cast<float>(phong.specular), static_cast<float>(phong.shininess));
}

void Renderer::Impl::bind_texture(GLenum unit, const mesh::TextureReference& reference, const Group& group) const {
    const GLuint texture = texture_of(reference, group);
    if (texture == 0) return;
    glActiveTexture(unit);
    glBindTexture(GL_TEXTURE_2D, texture);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, wrap_mode(reference.wrap_s));
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, wrap_mode(reference.wrap_t));
}

void Renderer::Impl::set_material(const Program& program, const mesh::Material& material, const Group& group) const {
    const bool blend = material.alpha_mode == mesh::AlphaMode::blend;
    const Vec4f& base = material.base_color;
    glUniform4f(program.base_color, base.r, base.g, base.b, base.a);
    glDepthMask(blend ? GL_FALSE : GL_TRUE);
    blend ? glEnable(GL_BLEND) : glDisable(GL_BLEND);
    if (is_of_discs(program)) return;  // opaque, without textures
    glUniform3f(program.emissive, material.emissive.r, material.emissive.g, material.emissive.b);
    if (program.alpha_cutoff >= 0) glUniform1f(program.alpha_cutoff, material.alpha_cutoff);
    bind_texture(GL_TEXTURE0, material.base_color_texture, group);
    bind_texture(GL_TEXTURE1, material.emissive_texture, group);
}

const Discs& Renderer::Impl::discs_of(const Shown& instance, const Batch& batch) const {
    return batch.group == &level ? instance.discs : batch.group->discs;
}

// Quads read their corners from no buffer, and an attribute once a disc.
void Renderer::Impl::draw_discs(const Program& program, const Discs& discs) {
    const float widening_px = target.samples > 1 ? 1.0f : 0.0f;
    const float largest_px = discs.as_quads ? largest_quad_px : max_point_px;
    glUniform3f(program.disc, discs.radius, widening_px, largest_px);
    for (const GLuint location : {location_position, location_color, location_normal_or_previous})
        glVertexAttribDivisor(location, discs.as_quads ? 1 : 0);
    if (discs.as_quads)
        glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, discs.points);
    else
        glDrawArrays(GL_POINTS, 0, discs.points);
    sent.points += static_cast<std::uint64_t>(discs.points);
}

bool Renderer::Impl::is_drawn(const Shown& instance, const Batch& batch, Style style, bool fades) const {
    if (batch.style == Style::points && discs_of(instance, batch).as_quads != (style == Style::quads)) return false;
    const Share share = both(batch.group->share, instance.share);
    return share.from < share.to && fades != is_whole(share);
}

void Renderer::Impl::draw_batch(const Program& program, const Batch& batch, Style style, bool fades) {
    const auto offset = static_cast<std::uintptr_t>(batch.first) * sizeof(std::uint32_t);
    const bool is_cloud = batch.style == Style::points;
    glBindVertexArray(batch.vertices.id);
    for (const Shown& instance : shown) {
        if (!is_drawn(instance, batch, style, fades)) continue;
        if (fades) set_share(program, both(batch.group->share, instance.share));
        glUniform3f(program.offset, instance.offset.x, instance.offset.y, instance.offset.z);
        ++sent.draw_calls;
        if (is_cloud) {
            draw_discs(program, discs_of(instance, batch));
            continue;
        }
        glDrawElements(GL_TRIANGLES, batch.corners, GL_UNSIGNED_INT, reinterpret_cast<const void*>(offset));
        sent.triangles += static_cast<std::uint64_t>(batch.corners) / 3;
    }
}

// Thresholds are counted in whole steps of the dither, so that no rounding shows one twice or never.
void Renderer::Impl::set_share(const Program& program, const Share& share) const {
    const GLint samples = has_sample_shading ? static_cast<GLint>(target.samples) : 1;
    const auto step = [&](double threshold) {
        return static_cast<GLint>(std::lround(threshold * dither_steps * samples));
    };
    glUniform3i(program.share, step(share.from), step(share.to), samples);
}

// Points are cheaper, but no larger than the driver allows, and gone where their centre is outside the picture.
bool Renderer::Impl::needs_quads(const Sphere& centers, double radius) const {
    const Sphere all{centers.center, centers.radius + radius};
    return std::any_of(exposures.begin(), exposures.end(), [&](const Camera& camera) {
        const double largest_px = largest_disc_px(camera, centers, radius, target.height);
        return largest_px > max_point_px || (largest_px > least_cut_px && !lies_within(camera, all));
    });
}

// Of a level of the cloud, scene coordinates; 0 of triangles.
double Renderer::Impl::disc_radius(std::uint64_t points) const {
    if (levels.empty() || points == 0) return 0.0;
    return std::min(points::level_of(levels, points).radius / placement.radius, largest_disc_radius);
}

// Of a cloud whose bounding sphere is there.
std::uint64_t Renderer::Impl::points_worth_drawing(const Sphere& sphere) const {
    if (levels.empty()) return level.uploaded.points;
    double px_per_unit = 0.0;
    for (const Camera& camera : exposures)
        px_per_unit = std::max(px_per_unit, largest_px_per_unit(camera, sphere, target.height));
    return std::min(level.uploaded.points,
                    points::points_worth_drawing(levels, px_per_unit / placement.radius, placement.radius));
}

// By any exposure: what only an earlier moment shows is shown.
bool Renderer::Impl::may_see(const Sphere& sphere) const {
    return std::any_of(exposures.begin(), exposures.end(),
                       [&](const Camera& camera) { return render::may_see(camera, sphere); });
}

Status Renderer::Impl::show_parts(const DrawOptions& options) {
    for (auto& [id, group] : parts) group.is_shown = false;
    for (const DrawnPart& drawn : options.parts) {
        const auto found = parts.find(drawn.part);
        if (found == parts.end())
            return invalid_input("part " + std::to_string(drawn.part) + " is not there to be drawn");
        if (!is_valid(drawn.share)) return invalid_input("a part's share is not in [0, 1]");
        Group& group = found->second;
        group.share = drawn.share;
        group.is_shown = false;
        group.discs.as_quads = false;
        if (!(drawn.share.from < drawn.share.to)) continue;
        for (const Shown& s : shown) {
            const Sphere centers{group.sphere.center + Vec3d(s.offset), group.sphere.radius};
            group.is_shown = group.is_shown || may_see({centers.center, centers.radius + group.discs.radius});
            group.discs.as_quads =
                group.discs.as_quads || (group.discs.points > 0 && needs_quads(centers, group.discs.radius));
        }
    }
    return Nothing{};
}

void Renderer::Impl::show(const DrawOptions& options, const std::vector<Sphere>& spheres) {
    shown.clear();
    for (std::size_t i = 0; i < spheres.size(); ++i) {
        const std::uint64_t points = std::min(options.instances[i].points, points_worth_drawing(spheres[i]));
        if (points == 0 && level.uploaded.points > 0) continue;
        const Share& share = options.instances[i].share;
        const double radius = disc_radius(points);
        const Sphere all{spheres[i].center, spheres[i].radius + radius};
        if (!may_see(all)) continue;
        const bool as_quads = points > 0 && needs_quads(spheres[i], radius);
        shown.push_back(
            {Vec3f(all.center), {static_cast<GLsizei>(points), static_cast<float>(radius), as_quads}, share});
    }
}

// The cameras of every exposure; several need samples of their own.
Status Renderer::Impl::expose(const shading::View& view, const DrawOptions& options, const Sphere& scene) {
    exposures.clear();
    if (options.earlier.size() >= options.samples) return invalid_input("more earlier moments than samples - 1");
    if (!options.earlier.empty() && (driver_version() < 31 || options.earlier.size() >= target.samples))
        return fail(ErrorCode::unsupported, "the graphics driver cannot give every exposure samples of its own");
    const double aspect = static_cast<double>(options.width) / options.height;
    for (const shading::View& moment : options.earlier) {
        if (auto sound = shading::validate(moment); !sound) return sound;
        exposures.push_back(make_camera(moment, origin, placement, aspect, scene));
    }
    exposures.push_back(make_camera(view, origin, placement, aspect, scene));
    return Nothing{};
}

// Every exposure writes to its own samples alone, depth included; resolving them makes the mean.
void Renderer::Impl::draw_exposures(const Program& program, const Batch& batch, Style style, bool fades) {
    if (exposures.size() == 1) return draw_batch(program, batch, style, fades);
    glEnable(GL_SAMPLE_MASK);
    for (std::size_t i = 0; i < exposures.size(); ++i) {
        GLbitfield samples = 0;
        for (std::size_t s = i; s < target.samples; s += exposures.size()) samples |= 1u << s;
        glSampleMaski(0, samples);
        const Camera& camera = exposures[i];
        set_camera(program, camera);
        if (camera.sees_scene) draw_batch(program, batch, style, fades);
    }
    glDisable(GL_SAMPLE_MASK);
}

// Blended primitives from back to front by their centres; triangles inside one are not sorted.
void Renderer::Impl::sort_blended() {
    const Vec3d& forward = exposures.back().forward;
    const auto first = std::find_if(batches.begin(), batches.end(), is_blended);
    std::stable_sort(first, batches.end(),
                     [&](const Batch& a, const Batch& b) { return dot(a.center, forward) > dot(b.center, forward); });
}

void Renderer::Impl::draw_batch_as(Style style, const Batch& batch, bool fades) {
    if (std::none_of(shown.begin(), shown.end(), [&](const Shown& s) { return is_drawn(s, batch, style, fades); }))
        return;
    const Program& program = programs.at(style, batch.look, fades);
    glUseProgram(program.id);
    const bool samples_apart = batch.style == Style::points && target.samples > 1 && has_sample_shading;
    set_material(program, batch.group->materials[batch.material], *batch.group);
    if (samples_apart) glEnable(GL_SAMPLE_SHADING);
    draw_exposures(program, batch, style, fades);
    if (samples_apart) glDisable(GL_SAMPLE_SHADING);
}

void Renderer::Impl::draw_frame(const std::vector<Vec4f>& lights, const DrawOptions& options) {
    const auto width = static_cast<GLint>(options.width), height = static_cast<GLint>(options.height);
    sent = {};
    glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
    glViewport(0, 0, width, height);
    glDisable(GL_CULL_FACE);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LEQUAL);
    glDepthMask(GL_TRUE);
    glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    glClearColor(options.background.r, options.background.g, options.background.b, 1.0f);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    if (!shown.empty()) {
        programs.for_each([&](const Program& program) {
            glUseProgram(program.id);
            set_camera(program, exposures.back());
            set_lights(program, lights, options.phong);
        });
        glVertexAttrib4f(location_color, 1.0f, 1.0f, 1.0f, 1.0f);
        glVertexAttrib3f(location_normal_or_previous, 0.0f, 0.0f, 0.0f);
        for (const Batch& batch : batches) {
            if (batch.corners == 0 || !batch.group->is_shown) continue;
            for (const bool fades : {false, true}) {
                draw_batch_as(batch.style, batch, fades);
                if (batch.style == Style::points) draw_batch_as(Style::quads, batch, fades);
            }
        }
        glBindVertexArray(0);
        glUseProgram(0);
    }
    if (target.samples == 1) return;
    glBindFramebuffer(GL_READ_FRAMEBUFFER, target.framebuffer);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, resolved.framebuffer);
    glBlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
}

Image Renderer::Impl::read_back(const DrawOptions& options) const {
    Image image{options.width, options.height, {}};
    image.rgba.resize(image.pixels() * 4);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, target.samples > 1 ? resolved.framebuffer : target.framebuffer);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, static_cast<GLsizei>(options.width), static_cast<GLsizei>(options.height), GL_RGBA,
                 GL_UNSIGNED_BYTE, image.rgba.data());
    flip_rows(image);
    for (std::size_t i = 3; i < image.rgba.size(); i += 4) image.rgba[i] = 255;
    return image;
}

Renderer::Renderer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;
Renderer::~Renderer() = default;

Result<Renderer> Renderer::create() {
    auto impl = std::make_unique<Impl>();
    if (auto made = impl->create(); !made) return made.error();
    return Renderer(std::move(impl));
}

template <class Level>
Result<UploadStatistics> Renderer::upload_or_clear(const Level& level) {
    Error error;
    try {
        auto statistics = impl_->upload(level);
        if (statistics) return statistics;
        error = statistics.error();
    } catch (const std::bad_alloc&) {
        error = fail(ErrorCode::limit_exceeded, "not enough memory to prepare the level for drawing");
    }
    impl_->clear();
    return error;
}

Result<UploadStatistics> Renderer::upload(const codec::Decoded& content) {
    return upload_or_clear(content);
}
Result<UploadStatistics> Renderer::upload(const MovableLevel& level) {
    return upload_or_clear(level);
}
Result<UploadStatistics> Renderer::upload(const codec::Points& content) {
    return upload_or_clear(content);
}
void Renderer::move_split(std::uint64_t gouraud) {
    impl_->move_split(gouraud);
}

Status Renderer::begin_scene(const Box& scene) {
    return impl_->begin_scene(scene);
}
Result<std::uint32_t> Renderer::add(const Part& part) {
    try {
        return impl_->add(part);
    } catch (const std::bad_alloc&) {
        impl_->remove(impl_->next_part - 1);
        return fail(ErrorCode::limit_exceeded, "not enough memory for a part of the scene");
    }
}
void Renderer::remove(std::uint32_t part) {
    impl_->remove(part);
}

Result<Frame> Renderer::draw(const shading::View& view, const DrawOptions& options) {
    if (auto sound = shading::validate(view); !sound) return sound.error();
    if (auto sound = impl_->check(options); !sound) return sound.error();
    if (auto ready = impl_->prepare_targets(options); !ready) return ready.error();
    const std::vector<Sphere> spheres = spheres_of(options.instances, impl_->placement);
    const std::vector<Vec4f> lights = lights_of(view, options);
    if (auto exposed = impl_->expose(view, options, around(spheres)); !exposed) return exposed.error();
    impl_->sort_blended();
    impl_->show(options, spheres);
    if (auto shown = impl_->show_parts(options); !shown) return shown.error();
    gl_failed();
    if (options.frames > 1) {  // the first frame also pays for what the driver compiles and moves
        impl_->draw_frame(lights, options);
        glFinish();
    }
    std::vector<double> times_ms;
    for (std::uint32_t i = 0; i < options.frames; ++i) {
        const auto start = std::chrono::steady_clock::now();
        impl_->draw_frame(lights, options);
        glFinish();
        times_ms.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    }
    try {
        Frame frame{impl_->read_back(options), median(std::move(times_ms))};
        frame.triangles = impl_->sent.triangles;
        frame.points = impl_->sent.points;
        frame.draw_calls = impl_->sent.draw_calls;
        if (gl_failed()) return out_of_memory("the frame");
        return frame;
    } catch (const std::bad_alloc&) {
        return fail(ErrorCode::limit_exceeded, "not enough memory for the picture");
    }
}

}  // namespace lodestream::render
