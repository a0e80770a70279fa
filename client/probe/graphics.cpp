#include "client/probe/graphics.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace lodestream::probe {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::uint32_t triangle_side_px = 256;  // small, so that triangles and not pixels are what costs
constexpr std::uint32_t fill_side_px = 512;
constexpr std::uint32_t fill_layers = 8;
constexpr std::uint32_t first_rings = 16, most_rings = 512;
constexpr double long_enough_ms = 8.0;  // of a frame: what is fixed counts for little
constexpr std::size_t least_runs = 3, most_runs = 200;
constexpr double most_overrun = 2.0;  // times the seconds, on a device whose frames take that long
constexpr int fixed_frames = 7;
constexpr double disc_share = 1.2;  // of a disc's radius to the side of a square that is its share of the surface

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

// A unit sphere of 4 * rings² triangles, `rings` from pole to pole and twice as many around.
mesh::Model ball(std::uint32_t rings) {
    mesh::Model model;
    model.materials.emplace_back();
    const std::uint32_t around = 2 * rings;
    for (std::uint32_t i = 0; i <= rings; ++i)
        for (std::uint32_t j = 0; j <= around; ++j) {
            const double polar = pi * (i + 0.01) / (rings + 0.02), turn = 2.0 * pi * j / around;
            const Vec3d p{std::sin(polar) * std::cos(turn), std::cos(polar), -std::sin(polar) * std::sin(turn)};
            model.mesh.positions.emplace_back(p);
            model.mesh.normals.emplace_back(p);
        }
    for (std::uint32_t i = 0; i < rings; ++i)
        for (std::uint32_t j = 0; j < around; ++j) {
            const std::uint32_t a = i * (around + 1) + j, b = a + around + 1;
            model.mesh.triangles.push_back({a, b, b + 1});
            model.mesh.triangles.push_back({a, b + 1, a + 1});
        }
    return model;
}

// Squares that cover the whole picture, one nearer than the other in the order in which they are drawn.
mesh::Model sheets() {
    mesh::Model model;
    model.materials.emplace_back();
    for (std::uint32_t layer = 0; layer < fill_layers; ++layer) {
        const float z = 0.01f * static_cast<float>(layer);
        const auto first = static_cast<std::uint32_t>(model.mesh.positions.size());
        for (const auto& [x, y] : {std::pair{-1.0f, -1.0f}, {1.0f, -1.0f}, {1.0f, 1.0f}, {-1.0f, 1.0f}}) {
            model.mesh.positions.push_back({x, y, z});
            model.mesh.normals.push_back({0, 0, 1});
        }
        model.mesh.triangles.push_back({first, first + 1, first + 2});
        model.mesh.triangles.push_back({first, first + 2, first + 3});
    }
    return model;
}

const shading::View at_ball{{0, 0, 3}, {0, 0, 0}, 45.0, {0.3, 1.0, 0.5}};
const shading::View at_sheets{{0, 0, 1.5}, {0, 0, 0}, 45.0, {0.3, 1.0, 0.5}};

render::DrawOptions square(std::uint32_t side_px) {
    render::DrawOptions options;
    options.width = options.height = side_px;
    options.samples = 1;
    return options;
}

Result<double> frame_ms(render::Renderer& renderer, const shading::View& view, std::uint32_t side_px) {
    const auto frame = renderer.draw(view, square(side_px));
    if (!frame) return frame.error();
    return std::max(frame->frame_ms, 1e-4);
}

// Frames for `seconds`; `amount` is what one of them draws.
Result<Rate> measure(render::Renderer& renderer, const shading::View& view, std::uint32_t side_px, double amount,
                     double seconds) {
    std::vector<double> rates;
    for (const auto begin = Clock::now(); rates.size() < most_runs;) {
        const double passed_s = seconds_since(begin);
        if (passed_s >= most_overrun * seconds || (passed_s >= seconds && rates.size() >= least_runs)) break;
        const auto ms = frame_ms(renderer, view, side_px);
        if (!ms) return ms.error();
        rates.push_back(amount / *ms * 1000.0);
    }
    return rate_of(std::move(rates));
}

// Doubles the ball until a frame is long enough to be measured well, which also wakes the driver; then measures.
// `content_of(ball)` is what is uploaded, `amount_of(ball)` what a frame draws of it.
template <class ContentOf, class AmountOf>
Result<Rate> growing(render::Renderer& renderer, double seconds, const ContentOf& content_of,
                     const AmountOf& amount_of) {
    const auto begin = Clock::now();
    for (std::uint32_t rings = first_rings;; rings *= 2) {
        const mesh::Model model = ball(rings);
        if (auto put = renderer.upload(content_of(model)); !put) return put.error();
        if (auto warm = frame_ms(renderer, at_ball, triangle_side_px); !warm) return warm.error();
        const auto ms = frame_ms(renderer, at_ball, triangle_side_px);
        if (!ms) return ms.error();
        const double left_s = seconds - seconds_since(begin);
        if (*ms >= long_enough_ms || rings >= most_rings || left_s < 0.5 * seconds)
            return measure(renderer, at_ball, triangle_side_px, static_cast<double>(amount_of(model)),
                           std::max(left_s, 0.25 * seconds));
    }
}

Result<Rate> triangles(render::Renderer& renderer, bool gouraud, double seconds) {
    const auto content_of = [&](const mesh::Model& model) {
        const std::vector<std::uint8_t> shades(model.mesh.triangles.size(), gouraud ? 1 : 0);
        return render::drawable(model, model.mesh, shades);
    };
    return growing(renderer, seconds, content_of, [](const mesh::Model& model) { return model.mesh.triangles.size(); });
}

// Discs that just cover the ball.
Result<Rate> points(render::Renderer& renderer, double seconds) {
    const auto content_of = [](const mesh::Model& model) {
        codec::Points content;
        content.cloud.positions = model.mesh.positions;
        content.cloud.normals = model.mesh.normals;
        const auto count = static_cast<double>(content.cloud.positions.size());
        content.levels.push_back({content.cloud.positions.size(), {}, disc_share * std::sqrt(4.0 * pi / count)});
        return content;
    };
    return growing(renderer, seconds, content_of, [](const mesh::Model& model) { return model.mesh.positions.size(); });
}

Result<Rate> pixels(render::Renderer& renderer, double seconds) {
    const mesh::Model model = sheets();
    if (auto put = renderer.upload(render::drawable(model, model.mesh)); !put) return put.error();
    if (auto warm = frame_ms(renderer, at_sheets, fill_side_px); !warm) return warm.error();
    return measure(renderer, at_sheets, fill_side_px, double{fill_layers} * fill_side_px * fill_side_px, seconds);
}

Result<double> fixed(render::Renderer& renderer) {
    const mesh::Model model = ball(2);
    if (auto put = renderer.upload(render::drawable(model, model.mesh)); !put) return put.error();
    std::vector<double> times_ms;
    for (int i = 0; i < fixed_frames; ++i) {
        const auto ms = frame_ms(renderer, at_ball, triangle_side_px);
        if (!ms) return ms.error();
        times_ms.push_back(*ms);
    }
    return median(std::move(times_ms));
}

}  // namespace

Result<Graphics> measure_graphics(render::Renderer& renderer, double seconds) {
    const auto smooth = triangles(renderer, true, seconds);
    if (!smooth) return smooth.error();
    const auto flat = triangles(renderer, false, seconds);
    if (!flat) return flat.error();
    const auto discs = points(renderer, seconds);
    if (!discs) return discs.error();
    const auto filled = pixels(renderer, seconds);
    if (!filled) return filled.error();
    const auto fixed_ms = fixed(renderer);
    if (!fixed_ms) return fixed_ms.error();
    return Graphics{*smooth, *flat, *discs, *filled, *fixed_ms};
}

}  // namespace lodestream::probe
