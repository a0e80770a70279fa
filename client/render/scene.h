// What the GPU gets, computed on the CPU in double precision; private to this folder and free of GL.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "client/render/renderer.h"

namespace lodestream::render {

// Scene coordinates: (p - center) / radius, so that everything drawn lies in the unit sphere around (0,0,0).
struct Placement {
    Vec3d center{0.0};    // relative to Decoded::origin
    double radius = 1.0;  // > 0
};

Placement place(const codec::Decoded& content);
Placement place(const codec::Points& content);

// Errors: invalid_input where an index, an attribute's length or a position is wrong.
Status check_drawable(const codec::Decoded& content);
Status check_drawable(const codec::Points& content);

// Vertex streams of a primitive; an attribute that is not drawn is empty.
struct Streams {
    std::vector<Vec3f> positions;
    std::vector<Vec3f> normals;                          // Gouraud
    std::vector<Vec3f> first_corners, previous_corners;  // flat: the other two corners of the face that a vertex lights
    std::vector<Rgba8> colors;
    std::vector<Vec2f> texture_coordinates;
    std::vector<std::uint32_t> indices;  // three a face, in the mesh's order
    Box bounds;                          // of the positions that triangles use
};

// Each triangle wound so that its front is the side that its normals point to.
Streams gouraud_streams(const mesh::Mesh& mesh, const Placement& placement, bool textured);
// Vertex f lights face f and is its last, provoking corner; as the other two serve vertices of other faces at their
// places, the ones drawn last where there is a choice. Places that no face lights from follow behind the faces. So a
// primitive has as many vertices as faces, or a few more.
Streams flat_streams(const mesh::Mesh& mesh, const Placement& placement, bool textured);

// Of a cloud: positions, normals (empty where it has none) and colours alone.
Streams disc_streams(const points::PointCloud& cloud, const Placement& placement);

// Scene coordinates.
struct Sphere {
    Vec3d center{0.0};
    double radius = 1.0;
};

// Of each instance's content in scene coordinates, and the sphere around all of them. pre: offsets are finite
std::vector<Sphere> spheres_of(const std::vector<Instance>& instances, const Placement& placement);
Sphere around(const std::vector<Sphere>& spheres);

// Hands over those of the images that the materials show, decoded. Warns of those that cannot be, are wider or taller
// than `widest`, or beyond what a level's textures may take.
std::vector<std::string> decode_shown(const std::vector<mesh::Image>& images,
                                      const std::vector<mesh::Material>& materials, std::uint32_t widest,
                                      const std::function<void(std::size_t image, Image&& pixels)>& take);
bool valid_image(const mesh::TextureReference& reference, std::size_t images);
bool is_textured(const mesh::Material& material, std::size_t images);

struct PreparedPrimitive {
    bool is_flat = false;
    std::uint32_t material = 0;
    std::uint64_t triangles = 0;
    Streams streams;
};

// Of a cloud: discs of one size.
struct PreparedDiscs {
    std::uint64_t points = 0;
    double radius = 0.0;  // scene coordinates
    Streams streams;
};

struct PreparedPart {
    Box scene;
    Sphere sphere;  // around its triangles or its points
    std::vector<PreparedPrimitive> primitives;
    PreparedDiscs discs;
    std::vector<mesh::Material> materials;
    std::vector<Image> images;  // empty where it is not shown
};

// Of a scene's box, from the world's origin. pre: not empty, finite
Placement place(const Box& scene);

struct Camera {
    bool sees_scene = false;  // false: all of it is behind the eye, or much smaller than a pixel
    Mat4f clip_from_scene{1.0f};
    Mat3f view_from_scene{1.0f};    // axes to the right, up and backwards
    double heights_per_unit = 1.0;  // of the picture, at depth 1
    Vec3f eye{0.0f};                // scene coordinates
    Vec3d forward{0.0};
};

// Unit directions and intensities of the options' lights, or of the view's one; x, y, z, intensity.
std::vector<Vec4f> lights_of(const shading::View& view, const DrawOptions& options);

// Near and far planes enclose `scene`. pre: validate(view) succeeded
Camera make_camera(const shading::View& view, const Vec3d& origin, const Placement& placement, double aspect,
                   const Sphere& scene = {});
// False only where no part of the sphere is in the picture.
bool may_see(const Camera& camera, const Sphere& sphere);
// Only where all of the sphere is between the picture's sides.
bool lies_within(const Camera& camera, const Sphere& sphere);
// Of a unit across the view at the sphere's nearest place; infinite where that is not in front of the eye.
double largest_px_per_unit(const Camera& camera, const Sphere& sphere, double height_px);
// No disc of this radius whose centre lies in both sphere and picture is larger in the picture, of `height_px`;
// infinite where one may reach beside the eye.
double largest_disc_px(const Camera& camera, const Sphere& sphere, double radius, double height_px);

}  // namespace lodestream::render
