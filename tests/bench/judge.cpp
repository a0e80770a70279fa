#include "tests/bench/judge.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "common/mesh/operations.h"

namespace lodestream::bench {

namespace {

std::vector<shading::View> views_along(const mesh::Model& model, const std::vector<Vec3d>& directions) {
    const Vec3d center = mesh::bounds(model.mesh).center();
    double radius = 0;
    for (const Vec3f& p : model.mesh.positions) radius = std::max(radius, length(Vec3d(p) - center));
    std::vector<shading::View> views;
    for (const Vec3d& toward : directions) {
        const Vec3d direction = normalize(toward);
        shading::View view;
        view.target = model.origin + center;
        view.eye = view.target + direction * (radius / std::sin(radians(view.fov_y_deg) / 2));
        const Vec3d aside = std::abs(direction.y) < 0.99 ? Vec3d{0, 1, 0} : Vec3d{1, 0, 0};
        view.light = direction + 0.6 * normalize(cross(direction, aside)) + Vec3d{0, 0.4, 0};
        views.push_back(view);
    }
    return views;
}

// pre: as many pictures, of the same sizes
ImageError image_error(const std::vector<render::Image>& full, const std::vector<render::Image>& level) {
    double squares = 0, pixels = 0, silhouette = 0;
    for (std::size_t i = 0; i < full.size(); ++i) {
        const Result<render::Difference> difference = render::compare(full[i], level[i]);
        if (!difference) throw std::runtime_error(difference.error().message);
        const double covered = static_cast<double>(difference->compared_pixels);
        squares += difference->rms * difference->rms * covered;
        pixels += covered;
        silhouette += static_cast<double>(difference->silhouette_pixels);
    }
    if (!(pixels > 0)) return {};
    return {std::sqrt(squares / pixels), 100 * silhouette / pixels};
}

}  // namespace

std::vector<shading::View> views_around(const mesh::Model& model) {
    std::vector<Vec3d> directions;
    for (int corner = 0; corner < 8; ++corner)
        directions.push_back({corner & 1 ? -0.8 : 1.0, corner & 2 ? -0.6 : 0.7, corner & 4 ? -0.9 : 1.1});
    return views_along(model, directions);
}

std::vector<shading::View> views_from_26(const mesh::Model& model) {
    std::vector<Vec3d> directions;
    for (int k = 0; k < 27; ++k)
        if (k != 13) directions.push_back({k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1});
    return views_along(model, directions);
}

Result<Painter> Painter::create() {
    Result<render::GlContext> context = render::create_headless_context();
    if (!context) return context.error();
    Result<render::Renderer> renderer = render::Renderer::create();
    if (!renderer) return renderer.error();
    return Painter(std::move(*context), std::move(*renderer));
}

std::vector<render::Image> Painter::draw(const mesh::Model& model, const mesh::Mesh& level,
                                         const std::vector<shading::View>& views) {
    return draw(render::drawable(model, level), views);
}

std::vector<render::Image> Painter::draw(const codec::Decoded& content, const std::vector<shading::View>& views) {
    const auto uploaded = renderer_.upload(content);
    if (!uploaded) throw std::runtime_error(uploaded.error().message);
    render::DrawOptions options;
    options.width = options.height = picture_side;
    options.samples = 1;
    options.phong.diffuse = 0.6;  // nothing is lit as bright as the white background
    options.phong.specular = 0.1;
    std::vector<render::Image> pictures;
    for (const shading::View& view : views) {
        Result<render::Frame> frame = renderer_.draw(view, options);
        if (!frame) throw std::runtime_error(frame.error().message);
        pictures.push_back(std::move(frame->image));
    }
    return pictures;
}

Gallery::Gallery(Painter& painter, const mesh::Model& model, std::vector<shading::View> views)
    : painter_(painter), model_(model), views_(std::move(views)), full_(painter.draw(model, model.mesh, views_)) {}

ImageError Gallery::show(const mesh::Model& materials, const mesh::Mesh& level) {
    const std::vector<render::Image> pictures = painter_.draw(materials, level, views_);
    shown_.push_back(pictures.front());
    return image_error(full_, pictures);
}

double Gallery::show_split(const mesh::Mesh& level, const std::vector<std::uint8_t>& gouraud, std::size_t view) {
    return image_error({full_[view]}, painter_.draw(render::drawable(model_, level, gouraud), {views_[view]})).rms;
}

void Gallery::write(const std::filesystem::path& file) {
    shown_.insert(shown_.begin(), full_.front());
    const Status written = render::write_png(file, render::side_by_side(shown_));
    if (!written) throw std::runtime_error(written.error().message);
    shown_.clear();
}

}  // namespace lodestream::bench
