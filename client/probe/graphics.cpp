#include "client/probe/graphics.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "client/probe/load_meter.h"
#include "client/render/image.h"
#include "common/base/random.h"

namespace lodestream::probe {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::uint32_t small_side_px = 64, triangle_side_px = 256, fill_side_px = 256, picture_side_px = 768;
constexpr std::uint32_t large_side_px = 1024;
constexpr std::uint32_t fill_layers = 32;
constexpr std::uint32_t few_rings = 2, coarse_rings = 5, fine_rings = 40;
constexpr std::uint32_t first_rings = 32, most_rings = 512;  // of the larger ball whose triangles count
constexpr std::uint32_t point_rings = 64;
constexpr std::uint32_t image_side = 512;  // texels
constexpr double jitter = 0.35;            // of a ball's vertices, in rows and columns
constexpr double long_enough_ms = 6.0;     // of a frame of that ball: what is fixed counts for little
constexpr int rounds = 4;                  // over all pictures, so that a slower moment is not one picture's alone
constexpr int waking_frames = 2;           // of each round, not counted: what the driver compiles and moves
constexpr std::size_t least_runs = 3, most_runs = 100;  // of a picture and a round
constexpr double most_overrun = 2.0;                    // times its seconds, on a device whose frames take that long
constexpr double share_to_search = 0.15;                // of the seconds, for a ball that takes long enough
constexpr double search_s = 0.01;                       // of each that is tried
// What models take over balls of the same figures, whose triangles are evener in size and order: the median over 22
// models, 754 frames on Mesa's llvmpipe (tests/bench, frame_time).
constexpr double model_over_ball = 1.12;
constexpr double near_eye = 3.0, far_eye = 200.0, sheets_eye = 1.5;
constexpr double disc_share = 1.2;  // of a disc's radius to the side of a square that is its share of the surface

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

// A unit sphere of 4 * rings² triangles, `rings` from pole to pole and twice as many around. Every other row is turned
// by half a triangle, so that triangles are about equilateral, and the poles lie askew. Triangles come row by row and
// vertices as they are used, as a decoder leaves them whose border grows over the surface: between a vertex's first and
// last use lies the whole border. Rows begin by turns on either side, so that as in models the near side is drawn over
// the far one as often as behind it.
mesh::Model ball(std::uint32_t rings) {
    const std::uint32_t around = 2 * rings;
    const Vec3d pole = normalize(Vec3d{0.5, 0.8, 0.0}), aside = normalize(cross(pole, Vec3d{0, 0, 1}));
    const Vec3d behind = cross(pole, aside);
    mesh::Model model;
    model.materials.emplace_back();
    Random random(rings);
    std::vector<std::uint32_t> names((rings + 1) * around, ~0u);
    const auto vertex = [&](std::uint32_t row, std::uint32_t column) {
        std::uint32_t& name = names[row * around + column % around];
        if (name != ~0u) return name;
        const bool is_inner = row > 0 && row < rings;
        const double polar = pi * (row + 0.01 + (is_inner ? random.uniform(-jitter, jitter) : 0.0)) / (rings + 0.02);
        const double turn = 2.0 * pi * (column + 0.5 * (row % 2) + random.uniform(-jitter, jitter)) / around;
        const Vec3d p = std::cos(polar) * pole + std::sin(polar) * (std::cos(turn) * aside + std::sin(turn) * behind);
        name = static_cast<std::uint32_t>(model.mesh.positions.size());
        model.mesh.positions.emplace_back(p);
        model.mesh.normals.emplace_back(p);
        return name;
    };
    for (std::uint32_t row = 0; row < rings; ++row)
        for (std::uint32_t i = 0; i < around; ++i) {
            const bool is_even = row % 2 == 0;
            const std::uint32_t column = i + (is_even ? 0 : rings);
            const std::uint32_t a = vertex(row, column), b = vertex(row, column + 1);
            const std::uint32_t c = vertex(row + 1, column), d = vertex(row + 1, column + 1);
            model.mesh.triangles.push_back({a, b, is_even ? c : d});
            model.mesh.triangles.push_back({is_even ? b : a, d, c});
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

shading::View from_distance(double distance) {
    return {{0, 0, distance}, {0, 0, 0}, 45.0, {0.3, 1.0, 0.5}};
}

render::DrawOptions square(std::uint32_t side_px) {
    render::DrawOptions options;
    options.width = options.height = side_px;
    options.samples = 1;
    return options;
}

// A level or a cloud.
struct Content {
    codec::Decoded level;
    std::optional<codec::Points> points;
};

// One picture that is timed, round after round.
struct Picture {
    std::size_t content = 0;
    double distance = near_eye;
    std::uint32_t side_px = triangle_side_px;
    std::vector<TimedRun> runs{};
};

Content smooth(const mesh::Model& model) {
    return {render::drawable(model, model.mesh), std::nullopt};
}

// With an image that is repeated across it, so that texels are smaller than pixels and mip levels are blended.
Result<Content> textured(mesh::Model model) {
    render::Image texels = render::solid(image_side, image_side, 200, 180, 160);
    for (std::size_t i = 0; i < texels.rgba.size(); ++i) texels.rgba[i] ^= static_cast<std::uint8_t>((i >> 5) & 63u);
    auto png = render::encode_png(texels);
    if (!png) return png.error();
    model.images.push_back({"image/png", *std::move(png), image_side, image_side});
    model.materials[0].base_color_texture.image = 0;
    for (const Vec3f& p : model.mesh.positions) model.mesh.texture_coordinates.push_back({2.0f * p.x, -2.0f * p.y});
    return smooth(model);
}

Content flat(const mesh::Model& model) {
    return {render::drawable(model, model.mesh, std::vector<std::uint8_t>(model.mesh.triangles.size(), 0)),
            std::nullopt};
}

// Discs that just cover the ball.
Content discs(const mesh::Model& model) {
    codec::Points content;
    content.cloud.positions = model.mesh.positions;
    content.cloud.normals = model.mesh.normals;
    const auto count = static_cast<double>(content.cloud.positions.size());
    content.levels.push_back({content.cloud.positions.size(), {}, disc_share * std::sqrt(4.0 * pi / count)});
    return {{}, std::move(content)};
}

Status upload(render::Renderer& renderer, const Content& content) {
    const auto put = content.points ? renderer.upload(*content.points) : renderer.upload(content.level);
    if (!put) return put.error();
    return Nothing{};
}

Result<TimedRun> draw(render::Renderer& renderer, const shading::View& view, const render::DrawOptions& options) {
    const double waited_before_ms = waited_ms();
    const auto frame = renderer.draw(view, options);
    if (!frame) return frame.error();
    return TimedRun{std::max(frame->frame_ms, 1e-4), waited_ms() - waited_before_ms};
}

// Draws what is uploaded for `seconds`.
Status time(render::Renderer& renderer, Picture& picture, double seconds) {
    const auto runs = timed_runs(renderer, from_distance(picture.distance), square(picture.side_px), seconds);
    if (!runs) return runs.error();
    picture.runs.insert(picture.runs.end(), runs->begin(), runs->end());
    return Nothing{};
}

// Rings of the smallest ball that takes long enough; doubled, so that the same device finds the same one.
Result<std::uint32_t> enough_rings(render::Renderer& renderer, double seconds) {
    const auto least_ms = [&](std::uint32_t rings) -> Result<double> {
        if (auto put = upload(renderer, smooth(ball(rings))); !put) return put.error();
        Picture picture;
        if (auto timed = time(renderer, picture, search_s); !timed) return timed.error();
        return timing_of(picture.runs).ms;
    };
    if (auto woken = least_ms(few_rings); !woken) return woken.error();
    const auto begin = Clock::now();
    for (std::uint32_t rings = first_rings;; rings *= 2) {
        const auto ms = least_ms(rings);
        if (!ms) return ms.error();
        if (*ms >= long_enough_ms || rings >= most_rings || seconds_since(begin) > seconds) return rings;
    }
}

enum : std::size_t { tiny, coarse, with_image, fine, fewer_smooth, more_smooth, fewer_flat, more_flat, cloud, layers };
enum : std::size_t {
    empty,
    wide,
    bare,
    covered,
    imaged,
    detailed,
    smooth_fewer,
    smooth_more,
    flat_fewer,
    flat_more,
    points,
    fill
};

// One after the other, round after round for as long as another round is expected to end in time.
Status time_all(render::Renderer& renderer, const std::vector<Content>& shown, std::vector<Picture>& pictures,
                double seconds) {
    const double each_s = seconds / (rounds * static_cast<double>(pictures.size()));
    const auto begin = Clock::now();
    for (int round = 1; round <= rounds; ++round) {
        for (Picture& picture : pictures) {
            if (auto put = upload(renderer, shown[picture.content]); !put) return put;
            if (auto timed = time(renderer, picture, each_s); !timed) return timed;
        }
        if (seconds_since(begin) * (round + 1) / round > most_overrun * seconds) break;
    }
    return Nothing{};
}

// Everything but points and layers, which levels do not have.
control::FrameCosts costs_of(const std::vector<Content>& shown, const std::vector<Picture>& pictures,
                             const std::vector<Timing>& timings) {
    std::vector<TimedPicture> timed;
    for (std::size_t i = empty; i <= flat_more; ++i) {
        const Picture& picture = pictures[i];
        timed.push_back(
            {work_of(shown[picture.content].level, from_distance(picture.distance), {picture.side_px, picture.side_px}),
             timings[i].ms});
    }
    control::FrameCosts costs = fit_costs(timed);
    for (double* cost : {&costs.per_million_triangles_ms, &costs.per_million_vertices_ms, &costs.per_million_shaded_ms,
                         &costs.per_million_textured_ms, &costs.per_million_extent_ms})
        *cost *= model_over_ball;
    return costs;
}

}  // namespace

Result<std::vector<TimedRun>> timed_runs(render::Renderer& renderer, const shading::View& view,
                                         const render::DrawOptions& options, double seconds) {
    for (int i = 0; i < waking_frames; ++i)
        if (auto woken = draw(renderer, view, options); !woken) return woken.error();
    std::vector<TimedRun> runs;
    const auto begin = Clock::now();
    while (runs.size() < most_runs) {
        const double passed_s = seconds_since(begin);
        if ((passed_s >= most_overrun * seconds && !runs.empty()) || (passed_s >= seconds && runs.size() >= least_runs))
            break;
        const auto run = draw(renderer, view, options);
        if (!run) return run.error();
        runs.push_back(*run);
    }
    return runs;
}

Result<Graphics> measure_graphics(render::Renderer& renderer, double seconds) {
    const auto rings = enough_rings(renderer, share_to_search * seconds);
    if (!rings) return rings.error();
    const mesh::Model more = ball(*rings), fewer = ball(*rings / 2);
    auto with_texels = textured(ball(coarse_rings));
    if (!with_texels) return with_texels.error();
    const std::vector<Content> shown{smooth(ball(few_rings)),
                                     smooth(ball(coarse_rings)),
                                     *std::move(with_texels),
                                     smooth(ball(fine_rings)),
                                     smooth(fewer),
                                     smooth(more),
                                     flat(fewer),
                                     flat(more),
                                     discs(ball(point_rings)),
                                     smooth(sheets())};
    std::vector<Picture> pictures{{tiny, far_eye, small_side_px},
                                  {tiny, far_eye, large_side_px},
                                  {coarse},
                                  {coarse, near_eye, picture_side_px},
                                  {with_image, near_eye, picture_side_px},
                                  {fine, near_eye, picture_side_px},
                                  {fewer_smooth},
                                  {more_smooth},
                                  {fewer_flat},
                                  {more_flat},
                                  {cloud},
                                  {layers, sheets_eye, fill_side_px}};
    if (auto timed = time_all(renderer, shown, pictures, (1.0 - share_to_search) * seconds); !timed)
        return timed.error();
    std::vector<Timing> timings;
    for (const Picture& picture : pictures) timings.push_back(timing_of(picture.runs));

    Graphics out;
    out.costs = costs_of(shown, pictures, timings);
    // The smaller ball's, which caches hold: what others of the same host do to memory moves the larger one's rate by a
    // tenth from second to second. The costs are of both.
    const auto triangles = static_cast<double>(fewer.mesh.triangles.size());
    out.gouraud_triangles = marginal_rate(triangles, timings[smooth_fewer], timings[bare]);
    out.flat_triangles = marginal_rate(triangles, timings[flat_fewer], timings[bare]);
    out.points = marginal_rate(static_cast<double>(shown[cloud].points->cloud.positions.size()), timings[points],
                               timings[empty]);
    out.pixels = marginal_rate(double{fill_layers} * fill_side_px * fill_side_px, timings[fill], timings[empty]);
    for (const Timing& timing : timings) {
        out.runs += timing.runs;
        out.calm_runs += timing.calm;
    }
    return out;
}

}  // namespace lodestream::probe
