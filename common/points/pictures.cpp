#include "common/points/pictures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "common/base/directions.h"
#include "common/base/raster.h"
#include "common/base/srgb.h"
#include "common/mesh/operations.h"
#include "common/points/view.h"
#include "common/shading/numbers.h"
#include "common/shading/phong.h"
#include "common/shading/view.h"

namespace lodestream::points {

namespace {

using shading::unit_or_zero;

constexpr std::size_t pixels = std::size_t{picture_side} * picture_side;
constexpr double nothing = -std::numeric_limits<double>::infinity();
constexpr double edge_on = 1e-6;  // of a disc's normal along the view

// An orthographic view: x to the right and y downwards in pixels, z towards the eye in the same unit.
struct Camera {
    Mat3d axes{1.0};  // columns: right, down, towards the eye
    Vec3d center{0.0};
    double px_per_unit = 1.0;

    const Vec3d& to_eye() const { return axes[2]; }
    Vec3d turned(const Vec3d& direction) const { return direction * axes; }
    Vec3d at(const Vec3f& position) const {
        return turned(Vec3d(position) - center) * px_per_unit + Vec3d(0.5 * picture_side, 0.5 * picture_side, 0.0);
    }
};

Camera camera_of(std::size_t view, const Box& box) {
    Camera camera;
    const Vec3d eye = spread_direction(view, picture_views);
    const Vec3d aside = std::abs(eye.y) < 0.9 ? Vec3d(0.0, 1.0, 0.0) : Vec3d(1.0, 0.0, 0.0);
    const Vec3d right = normalize(cross(aside, eye));
    camera.axes = Mat3d(right, cross(right, eye), eye);
    camera.center = box.center();
    const double radius = box.radius();
    if (radius > 0.0) camera.px_per_unit = 0.5 * picture_side / radius;
    return camera;
}

struct Light {
    double diffuse = 0.0, specular = 0.0;
};

// As the renderer does, of one white light; `normal` of unit length or zero, on the side that is seen.
Light light_on(const Vec3d& normal, const Vec3d& to_eye) {
    static const Vec3d to_light = normalize(shading::View{}.light);
    constexpr shading::Phong phong;
    const double lambert = dot(normal, to_light);
    if (!(lambert > 0.0)) return {phong.ambient, 0.0};
    const double highlight = std::max(dot(2.0 * lambert * normal - to_light, to_eye), 0.0);
    return {phong.ambient + phong.diffuse * lambert, phong.specular * std::pow(highlight, phong.shininess)};
}

double srgb(double light) {
    return srgb_of_light(std::min(light, 1.0));
}

Vec3f shown(const Light& light, const Vec3d& color) {
    const Vec3d lit = color * light.diffuse + Vec3d(light.specular);
    return Vec3f(srgb(lit.x), srgb(lit.y), srgb(lit.z));
}

Vec3d linear(const Rgba8& color) {
    return Vec3d(color.r, color.g, color.b) / 255.0;
}

// What is nearest to the eye, pixel by pixel.
struct Picture {
    std::vector<double> depths = std::vector<double>(pixels, nothing);
    std::vector<Vec3f> colors = std::vector<Vec3f>(pixels, Vec3f(1.0f));  // sRGB; the background is white

    bool covers(std::size_t pixel) const { return depths[pixel] > nothing; }
    bool hides(std::size_t pixel, double depth) const { return !(depth > depths[pixel]); }
};

class SurfacePainter {
  public:
    SurfacePainter(const Surface& surface, const Camera& camera)
        : surface_(surface), camera_(camera), is_gouraud_(!surface.is_flat && !surface.mesh.normals.empty()) {
        places_.reserve(surface.mesh.positions.size());
        for (const Vec3f& position : surface.mesh.positions) places_.push_back(camera.at(position));
    }

    Picture paint() {
        for (std::uint32_t i = 0; i < surface_.mesh.triangles.size(); ++i) find(i);
        for (std::size_t pixel = 0; pixel < pixels; ++pixel)
            if (picture_.covers(pixel)) picture_.colors[pixel] = color_of(nearest_[pixel]);
        return std::move(picture_);
    }

  private:
    struct Place {
        std::uint32_t triangle = 0;
        Vec3f weights{0.0f};
    };

    void find(std::uint32_t triangle) {
        const mesh::Triangle& t = surface_.mesh.triangles[triangle];
        const std::array<Vec3d, 3> at{places_[t[0]], places_[t[1]], places_[t[2]]};
        for_each_pixel(at, picture_side, picture_side, [&](std::uint32_t x, std::uint32_t y) {
            Vec3d weights;
            if (!weights_at(at, x + 0.5, y + 0.5, weights)) return;
            const double depth = dot(weights, Vec3d(at[0].z, at[1].z, at[2].z));
            const std::size_t pixel = std::size_t{y} * picture_side + x;
            if (picture_.hides(pixel, depth)) return;
            picture_.depths[pixel] = depth;
            nearest_[pixel] = {triangle, Vec3f(weights)};
        });
    }

    Vec3f color_of(const Place& place) const {
        const mesh::Triangle& t = surface_.mesh.triangles[place.triangle];
        const auto& p = surface_.mesh.positions;
        const Vec3d face = unit_or_zero(mesh::face_normal(p[t[0]], p[t[1]], p[t[2]]));
        const Light light = is_gouraud_ ? gouraud(t, face, place.weights)
                                        : light_on(dot(face, camera_.to_eye()) < 0.0 ? -face : face, camera_.to_eye());
        return shown(light, surface_.color ? linear(surface_.color(place.triangle, place.weights)) : Vec3d(1.0));
    }

    // A face's front is the side that its normals point to.
    Light gouraud(const mesh::Triangle& t, const Vec3d& face, const Vec3f& weights) const {
        const auto& n = surface_.mesh.normals;
        const Vec3d sum = Vec3d(n[t[0]]) + Vec3d(n[t[1]]) + Vec3d(n[t[2]]);
        const double side = (dot(face, sum) < 0.0) == (dot(face, camera_.to_eye()) < 0.0) ? 1.0 : -1.0;
        Light light;
        for (int k = 0; k < 3; ++k) {
            const Light corner = light_on(side * unit_or_zero(Vec3d(n[t[k]])), camera_.to_eye());
            light.diffuse += weights[k] * corner.diffuse;
            light.specular += weights[k] * corner.specular;
        }
        return light;
    }

    const Surface& surface_;
    const Camera& camera_;
    const bool is_gouraud_;
    std::vector<Vec3d> places_;
    std::vector<Place> nearest_ = std::vector<Place>(pixels);
    Picture picture_;
};

// The middles of pixels whose rays meet the disc.
void paint_disc(const Camera& camera, const Vec3d& at, const Vec3d& normal, double radius, const Vec3f& color,
                Picture& picture) {
    const Vec3d n = camera.turned(normal);
    if (std::abs(n.z) < edge_on) return;
    const Vec3d reach = radius * sqrt(max(Vec3d(1.0) - n * n, Vec3d(0.0)));
    const PixelRange rows = pixels_between(at.y - reach.y, at.y + reach.y, picture_side);
    const PixelRange columns = pixels_between(at.x - reach.x, at.x + reach.x, picture_side);
    for (std::uint32_t y = rows.first; y < rows.last; ++y)
        for (std::uint32_t x = columns.first; x < columns.last; ++x) {
            Vec3d off(x + 0.5 - at.x, y + 0.5 - at.y, 0.0);
            off.z = -(n.x * off.x + n.y * off.y) / n.z;
            const std::size_t pixel = std::size_t{y} * picture_side + x;
            if (dot(off, off) > radius * radius || picture.hides(pixel, at.z + off.z)) continue;
            picture.depths[pixel] = at.z + off.z;
            picture.colors[pixel] = color;
        }
}

Picture picture_of(const Surface& surface, const Camera& camera) {
    return SurfacePainter(surface, camera).paint();
}

Picture picture_of(const Discs& discs, const Camera& camera) {
    const PointCloud& cloud = discs.cloud;
    Picture picture;
    for (std::size_t i = 0; i < std::min<std::uint64_t>(discs.count, cloud.positions.size()); ++i) {
        Vec3d normal = cloud.normals.empty() ? Vec3d(0.0) : unit_or_zero(Vec3d(cloud.normals[i]));
        if (normal == Vec3d(0.0)) normal = camera.to_eye();
        if (dot(normal, camera.to_eye()) < 0.0) normal = -normal;
        const Vec3d color = cloud.colors.empty() ? Vec3d(1.0) : linear(cloud.colors[i]);
        paint_disc(camera, camera.at(cloud.positions[i]), normal, discs.radius * camera.px_per_unit,
                   shown(light_on(normal, camera.to_eye()), color), picture);
    }
    return picture;
}

}  // namespace

struct Pictures::Impl {
    Impl(const Surface& full, const simplify::Executor& executor) : pictures(picture_views) {
        Box box = mesh::bounds(full.mesh);
        for (std::size_t view = 0; view < picture_views; ++view) cameras.push_back(camera_of(view, box));
        simplify::run(executor, picture_views,
                      [&](std::size_t view) { pictures[view] = picture_of(full, cameras[view]); });
        for (const Picture& picture : pictures)
            for (std::size_t pixel = 0; pixel < pixels; ++pixel) covered += picture.covers(pixel) ? 1 : 0;
    }

    template <class Level>
    double error(const Level& level) const {
        if (covered == 0) return 0.0;
        double squares = 0.0;
        for (std::size_t view = 0; view < picture_views; ++view) {
            const Picture picture = picture_of(level, cameras[view]);
            for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
                const Vec3d off(picture.colors[pixel] - pictures[view].colors[pixel]);
                squares += dot(off, off) / 3.0;
            }
        }
        return std::sqrt(squares / static_cast<double>(covered));
    }

    std::vector<Camera> cameras;
    std::vector<Picture> pictures;
    std::uint64_t covered = 0;  // pixels, of all pictures
};

Pictures::Pictures(const Surface& full, const simplify::Executor& executor)
    : impl_(std::make_unique<Impl>(full, executor)) {}
Pictures::~Pictures() = default;
Pictures::Pictures(Pictures&&) noexcept = default;
Pictures& Pictures::operator=(Pictures&&) noexcept = default;

double Pictures::error(const Surface& level) const {
    return impl_->error(level);
}
double Pictures::error(const Discs& level) const {
    return impl_->error(level);
}

}  // namespace lodestream::points
