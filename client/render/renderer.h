// Draws a decoded level with OpenGL ES 3.0: Gouraud primitives are lit once a vertex, flat primitives once a face, and
// a fragment only multiplies the light that arrives with the base colour's texture.
//
// Flat faces need no normals in memory and are lit exactly once: every vertex of a flat primitive carries its own
// position and those of the two other corners of the one face that it provokes, works out the normal, and serves the
// faces around it as a mere position. The price is 48 bytes a face, where indexed Gouraud takes about 24 (normals,
// shared vertices), and one evaluation a face, where indexed Gouraud takes about one for two faces. What flat shading
// saves is therefore bytes on the wire and decoding, not drawing.
//
// Light: Phong's model from 1 to 64 directions plus ambient (shading::Phong), computed in linear light, written as
// sRGB. Faces are lit from both sides: a face seen from behind uses the opposite normal. Nothing is culled. Of a
// material the base colour, emission, their textures and the alpha mode are drawn; roughness and metalness are not part
// of Phong's model.
//
// A point cloud is drawn as discs on its tangent planes, as large as its level needs to leave no hole, lit once each.
// Where the driver has samples of their own (OpenGL ES 3.2) discs are anti-aliased like triangles, else pixel by pixel.
// Discs are points where points show them whole, and quads, which take a software renderer up to four times as long,
// where an instance comes so near that a disc may be larger than the driver's largest point or lie across the picture's
// edge by more than a few pixels. One whose centre is behind the eye is not drawn.
//
// More points than a picture needs are not drawn: of each instance only so many of the cloud's first points as make
// discs of points::least_disc_px where it is nearest, as far as its levels tell. As any prefix is a level, that changes
// a few points a frame, and a crowd costs what it covers.
//
// A scene may be put together of parts that come and go, such as a tileset's tiles. Levels fade into each other by
// dither: every sample of the canvas has a threshold in [0, 1) that stays where it is, a different one for each sample
// of a square of 8 by 8 pixels, and a part is drawn at the samples whose thresholds are in its share. Parts whose
// shares together are [0, 1) so show exactly one of them at every sample. Instances have shares too: the same place
// with two levels of a cloud is a level that fades into another. Where the driver tells samples apart (OpenGL ES 3.2) a
// pixel goes over in as many steps as it has samples, else at once.
//
// Numbers: the scene is moved to its bounding sphere's centre and scaled to radius 1 in double precision before
// anything becomes float, so extents of 1e-9 or 1e9 and origins far away draw alike.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "client/render/image.h"
#include "client/render/movable_level.h"
#include "common/base/result.h"
#include "common/codec/level_codec.h"
#include "common/codec/points_codec.h"
#include "common/mesh/mesh.h"
#include "common/shading/phong.h"
#include "common/shading/view.h"

namespace lodestream::render {

inline constexpr std::uint32_t max_samples = 8;
inline constexpr std::size_t max_lights = 64;
inline constexpr std::uint64_t max_texture_texels = 256ull << 20;  // of all images of a level together

// From infinitely far away, white.
struct Light {
    Vec3d direction{0.3, 1.0, 0.5};  // towards the light, world axes; any finite length but zero
    double intensity = 1.0;          // >= 0
};

inline constexpr std::uint64_t all_points = ~std::uint64_t{0};

// Of the thresholds in [0, 1), those that a part or an instance is drawn at: from <= threshold < to.
struct Share {
    double from = 0.0;
    double to = 1.0;
};

// The uploaded content once more at another place.
struct Instance {
    Vec3d offset{0.0};                  // world axes, model units; in float once divided by the content's radius
    std::uint64_t points = all_points;  // of a cloud: the level, its first points, at most; a mesh is drawn whole
    Share share{};                      // of a scene's parts at thresholds that are in both
};

struct DrawnPart {
    std::uint32_t part = 0;  // as Renderer::add() named it
    Share share{};
};

struct DrawOptions {
    std::uint32_t width = 800;   // px, >= 1, at most image::max_side and what the driver allows
    std::uint32_t height = 600;  // px, likewise
    std::uint32_t samples = 4;   // a pixel; 1 turns anti-aliasing off, which is right where images are compared
    std::uint32_t frames = 1;    // frame_ms is the median over that many, >= 1
    Vec3f background{1.0f};      // linear RGB
    // Moments before the drawn view: the picture is the mean of all of them and the view. Each costs a drawing of the
    // scene, and takes its share of the samples: at most samples - 1, and OpenGL ES 3.1 is needed.
    std::vector<shading::View> earlier{};
    shading::Phong phong{};
    std::vector<Light> lights{};                  // at most max_lights; empty: the view's light alone, at intensity 1
    std::vector<Instance> instances{Instance{}};  // those that no picture can show are left out
    std::vector<DrawnPart> parts{};               // of the scene that was begun; likewise
};

struct Frame {
    Image image;
    double frame_ms = 0.0;        // drawing until the GPU is done, without reading the picture back
    std::uint64_t triangles = 0;  // sent to the GPU, once for every instance and exposure
    std::uint64_t points = 0;     // likewise, as many of each instance's as are worth drawing
    std::uint32_t draw_calls = 0;
};

struct UploadStatistics {
    std::uint64_t triangles = 0;
    std::uint64_t points = 0;
    std::uint64_t gouraud_triangles = 0;
    std::uint64_t gouraud_vertices = 0;  // one evaluation of the light each
    std::uint64_t flat_vertices = 0;     // likewise
    std::uint64_t geometry_bytes = 0;    // vertex and index buffers on the GPU
    std::uint64_t texture_bytes = 0;     // without mip levels
};

// A level as its decoded bytes would be, without encoding it: one primitive a material and shading. Empty `gouraud`:
// all Gouraud. Gouraud triangles of a mesh without normals are flat. pre: gouraud is empty or one entry a triangle
codec::Decoded drawable(const mesh::Model& model, const mesh::Mesh& level, std::span<const std::uint8_t> gouraud = {});

struct PreparedPart;  // scene.h

// A content of a scene as the GPU takes it.
struct Part {
    std::shared_ptr<const PreparedPart> prepared;
    std::uint64_t triangles = 0;
    std::uint64_t points = 0;
    std::uint64_t gpu_bytes = 0;  // buffers, and textures with their mip levels
};

// Does what needs no GPU, on any thread. All parts of a scene have its box, so what they share is at one place to the
// bit. Images that cannot be decoded are drawn white and warned of. Errors: as upload(), invalid_input (the box).
Result<Part> prepare(const codec::Decoded& content, const Box& scene);
// The same of a cloud: all of it, in the discs of its finest level.
Result<Part> prepare(const codec::Points& content, const Box& scene);

// Around everything that triangles use, in world coordinates.
Box world_bounds(const codec::Decoded& content);
Box world_bounds(const codec::Points& content);

// Where a point of the world is in a picture of the view: with p = m * (x, y, z, 1), p.x / p.w and p.y / p.w are pixels
// from its top left corner, and p.w is the depth in front of the eye. pre: validate(view) succeeded
Mat4d pixels_from_world(const shading::View& view, std::uint32_t width, std::uint32_t height);

// Needs a current OpenGL ES 3 context, the same one for its whole life and at its end.
class Renderer {
  public:
    // Errors: unavailable (no context is current, or an older one than OpenGL ES 3), limit_exceeded (GPU memory),
    // internal (the driver does not take the shaders; what it says of them).
    static Result<Renderer> create();
    Renderer(Renderer&&) noexcept;
    Renderer& operator=(Renderer&&) noexcept;
    ~Renderer();

    // Puts the level on the GPU in place of the one before, which goes first: weak devices have no memory for both.
    // Images that cannot be decoded are drawn white and warned of. After an error nothing is on the GPU. Errors:
    // invalid_input (an index or attribute length is wrong, positions not finite), limit_exceeded (GPU memory).
    Result<UploadStatistics> upload(const codec::Decoded& content);

    // The same of a level whose border between Gouraud and flat may move; all Gouraud at first.
    Result<UploadStatistics> upload(const MovableLevel& level);

    // The same of a cloud; any prefix of it can be drawn (Instance::points).
    Result<UploadStatistics> upload(const codec::Points& content);

    // Draws the first `gouraud` triangles of an uploaded movable level Gouraud and the rest flat (all of them where it
    // has fewer): sets two ranges a material, uploads nothing. Without a movable level, nothing.
    void move_split(std::uint64_t gouraud);

    // Begins a scene of parts in place of what was there. Errors: invalid_input (an empty or infinite box).
    Status begin_scene(const Box& scene);

    // Puts a part of the scene on the GPU and names it; drawn where DrawOptions::parts says so. Errors: invalid_input
    // (prepared for another scene), limit_exceeded (GPU memory; the scene is as before).
    Result<std::uint32_t> add(const Part& part);

    // Takes it off the GPU. A part that is not there: nothing.
    void remove(std::uint32_t part);

    // Draws what was uploaded or, of a scene, the parts asked for; without either the background alone.
    // Errors: invalid_input (view, sizes, a part that is not there, more earlier moments than samples - 1),
    // limit_exceeded (larger than the driver or the named limits allow), unsupported (earlier moments, and the driver
    // has no sample masks or fewer samples).
    Result<Frame> draw(const shading::View& view, const DrawOptions& options);

  private:
    struct Impl;
    explicit Renderer(std::unique_ptr<Impl> impl);
    template <class Level>
    Result<UploadStatistics> upload_or_clear(const Level& level);
    std::unique_ptr<Impl> impl_;
};

}  // namespace lodestream::render
