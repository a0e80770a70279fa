#include "client/fly/pilot.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <thread>

namespace lodestream::fly {

namespace {

using Clock = std::chrono::steady_clock;

constexpr int timed_runs = 5;
constexpr double smallest_ms = 1e-3;
constexpr motion::Pose looking_away{std::nullopt, 180.0, motion::max_pitch_deg};
constexpr double least_more_in_view = 0.1;         // than when looking away, for the cost of what is seen to be told
constexpr std::uint32_t small_screen_divisor = 4;  // of each side, to tell pixels' cost from that of triangles

double ms_since(Clock::time_point start) {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

render::DrawOptions draw_options(const Screen& screen) {
    render::DrawOptions options;
    options.width = screen.width;
    options.height = screen.height;
    options.samples = blur_samples;
    return options;
}

// The level in place of what was on the GPU; the part to draw, none of a movable level.
Result<std::vector<render::DrawnPart>> put(render::Renderer& renderer, const Scenery& scenery, std::size_t level) {
    const SceneryLevel& shown = scenery.levels[level];
    if (shown.movable) {
        const auto there = renderer.upload(*shown.movable);
        if (!there) return there.error();
        return std::vector<render::DrawnPart>{};
    }
    if (auto begun = renderer.begin_scene(scenery.bounds); !begun) return begun.error();
    const auto part = renderer.add(shown.part);
    if (!part) return part.error();
    return std::vector<render::DrawnPart>{{*part}};
}

Result<render::Frame> draw(render::Renderer& renderer, const std::vector<render::DrawnPart>& parts,
                           const shading::View& home, const Screen& screen, const std::vector<motion::Pose>& poses) {
    render::DrawOptions options = draw_options(screen);
    options.parts = parts;
    for (std::size_t i = 0; i + 1 < poses.size(); ++i) options.earlier.push_back(view_of(home, poses[i]));
    return renderer.draw(view_of(home, poses.back()), options);
}

// Draws what the loop asks for and keeps the level that is on the GPU.
class Pilot {
  public:
    Pilot(render::Renderer& renderer, const Scenery& scenery, const PilotOptions& options)
        : renderer_(renderer),
          scenery_(scenery),
          options_(options),
          home_(default_view(scenery, options.screen.fov_y_deg)) {}

    Result<control::FrameOutcome> draw_frame(const control::FrameRequest& request) {
        const SceneryLevel& level = scenery_.levels[request.level];
        const shading::View view = view_of(home_, request.poses.back());
        wait_for_display();
        double upload_ms = 0.0;
        if (level_ != request.level) {
            const auto start = Clock::now();
            auto there = put(renderer_, scenery_, request.level);
            if (!there) return there.error();
            parts_ = *std::move(there);
            if (level_) upload_ms = ms_since(start);  // the first one is there before the flight begins
            enter(level);
            level_ = request.level;
        }
        const BorderMove move = level.movable ? move_border(*level.movable, view) : BorderMove{};
        auto frame = draw(renderer_, parts_, home_, options_.screen, request.poses);
        if (!frame) return frame.error();
        if (options_.on_frame)
            if (auto taken = options_.on_frame(frame->image, request); !taken) return taken.error();
        if (level.movable && options_.on_split)
            if (auto told = tell_split(move, *level.movable, request, frame->image); !told) return told.error();
        const double pixels = shading::pixels_per_unit(view, scenery_.bounds, display_of(options_.screen));
        return control::FrameOutcome{upload_ms + frame->frame_ms, 0.0, level.max_error * pixels};
    }

  private:
    struct BorderMove {
        std::uint64_t before = 0, after = 0;  // Gouraud triangles
        double squared_change = 0.0;          // the bound, model units²
        double pixels_per_unit = 0.0;         // at the level's nearest point
    };

    // A frame begins a deadline after the one before at the soonest, as on a display, so that a flight takes the time
    // that it shows and leaves the device as much rest.
    void wait_for_display() {
        std::this_thread::sleep_until(next_);
        const std::chrono::duration<double, std::milli> deadline(control::deadline_ms(options_.control));
        next_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(deadline);
    }

    // The border keeps its share of the triangles from level to level.
    void enter(const SceneryLevel& level) {
        if (!level.movable) return;
        if (split_) split_ = shading::on_level(*split_, triangles_, level.movable->triangles());
        triangles_ = level.movable->triangles();
        bounds_ = render::world_bounds(level.movable->content);
    }

    BorderMove move_border(const render::MovableLevel& level, const shading::View& view) {
        const budget::Display display = display_of(options_.screen);
        const double distance = shading::continuous_distance(view, bounds_, display);
        const std::uint32_t steps = options_.distance_steps ? options_.distance_steps() : shading::max_distance_steps;
        if (!split_) split_ = shading::settled_split(distance, steps, triangles_);
        const std::uint64_t before = split_->gouraud;
        const shading::SplitMove move =
            shading::move_split(*split_, distance, steps, {level.difference_left, level.radius}, options_.split);
        split_ = move.state;
        renderer_.move_split(split_->gouraud);
        return {before, split_->gouraud, move.squared_change, shading::pixels_per_unit(view, bounds_, display)};
    }

    Status tell_split(const BorderMove& move, const render::MovableLevel& level, const control::FrameRequest& request,
                      const render::Image& shown) {
        SplitFrame split{move.after, 0.0, 0.0};
        if (move.before != move.after) {
            renderer_.move_split(move.before);
            const auto before = draw(renderer_, parts_, home_, options_.screen, request.poses);
            renderer_.move_split(move.after);
            if (!before) return before.error();
            const auto difference = render::compare(before->image, shown);
            if (!difference) return difference.error();
            const double radius_px = level.radius * move.pixels_per_unit;
            split.bound_steps = 255.0 * std::sqrt(move.squared_change / pi) / level.radius;
            split.change_steps =
                difference->rms * std::sqrt(static_cast<double>(difference->compared_pixels) / pi) / radius_px;
        }
        options_.on_split(split);
        return Nothing{};
    }

    render::Renderer& renderer_;
    const Scenery& scenery_;
    const PilotOptions& options_;
    shading::View home_;
    Clock::time_point next_{};  // frame, at the soonest
    std::optional<std::uint32_t> level_;
    std::vector<render::DrawnPart> parts_;      // of that level
    std::optional<shading::SplitState> split_;  // of a movable level
    std::uint64_t triangles_ = 0;               // likewise
    Box bounds_;                                // likewise, world axes
};

// How much of a scenery a pose sees.
class Sight {
  public:
    Sight(const Scenery& scenery, const Screen& screen)
        : points_(sampled_triangles(scenery)),
          home_(default_view(scenery, screen.fov_y_deg)),
          display_(display_of(screen)) {}
    double operator()(const motion::Pose& pose) const { return share_in_view(points_, view_of(home_, pose), display_); }

  private:
    std::vector<Vec3d> points_;
    shading::View home_;
    budget::Display display_;
};

double positive(double ms) {
    return std::max(ms, smallest_ms);
}

}  // namespace

budget::Display display_of(const Screen& screen) {
    return {screen.width, screen.height};
}

// The first frame wakes the driver.
Result<double> time_frame(render::Renderer& renderer, const Scenery& scenery, std::size_t level,
                          const std::vector<motion::Pose>& poses, const Screen& screen) {
    const auto parts = put(renderer, scenery, level);
    if (!parts) return parts.error();
    const shading::View home = default_view(scenery, screen.fov_y_deg);
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i <= timed_runs; ++i) {
        const auto frame = draw(renderer, *parts, home, screen, poses);
        if (!frame) return frame.error();
        if (i > 0) least = std::min(least, frame->frame_ms);
    }
    return least;
}

Result<LevelTimes> time_level(render::Renderer& renderer, const Scenery& scenery, std::size_t level,
                              const Screen& screen) {
    LevelTimes times{0.0, std::numeric_limits<double>::infinity()};
    for (int i = 0; i < timed_runs; ++i) {
        const auto start = Clock::now();
        if (auto there = put(renderer, scenery, level); !there) return there.error();
        times.upload_ms = std::min(times.upload_ms, ms_since(start));
    }
    const auto draw_ms = time_frame(renderer, scenery, level, {motion::Pose{}}, screen);
    if (!draw_ms) return draw_ms.error();
    times.draw_ms = *draw_ms;
    return times;
}

Result<control::FrameCosts> measure_costs(render::Renderer& renderer, const Scenery& scenery, const Screen& screen,
                                          bool blurs) {
    const auto finest = time_level(renderer, scenery, 0, screen);
    if (!finest) return finest.error();
    const auto away_ms = time_frame(renderer, scenery, 0, {looking_away}, screen);
    if (!away_ms) return away_ms.error();
    const std::size_t last = scenery.levels.size() - 1;
    const auto coarsest = time_level(renderer, scenery, last, screen);
    if (!coarsest) return coarsest.error();
    Screen small = screen;
    small.width = std::max(1u, screen.width / small_screen_divisor);
    small.height = std::max(1u, screen.height / small_screen_divisor);
    const auto small_ms = time_frame(renderer, scenery, last, {motion::Pose{}}, small);
    if (!small_ms) return small_ms.error();
    const std::uint32_t exposures = blurs ? control::max_exposures : 1;
    const auto blurred_ms = time_frame(renderer, scenery, last, std::vector<motion::Pose>(exposures), screen);
    if (!blurred_ms) return blurred_ms.error();

    const Sight sight(scenery, screen);
    const double in_view = sight({}), more_in_view = in_view - sight(looking_away);
    const double millions = 1e-6 * static_cast<double>(scenery.levels[0].triangles);
    const double few_millions = 1e-6 * static_cast<double>(scenery.levels[last].triangles);
    const double megapixels = 1e-6 * screen.width * screen.height;
    const double fewer_megapixels = megapixels - 1e-6 * small.width * small.height;
    const double per_million_ms = millions > few_millions
                                      ? (finest->draw_ms - coarsest->draw_ms) / (millions - few_millions)
                                      : finest->draw_ms / millions;
    const double exposure_ms = blurs ? (*blurred_ms - coarsest->draw_ms) / (exposures - 1) : 0.0;
    const double pixels_ms = fewer_megapixels > 0.0 ? (coarsest->draw_ms - *small_ms) / fewer_megapixels : 0.0;
    control::FrameCosts costs;
    costs.per_million_shaded_ms = positive((exposure_ms - few_millions * per_million_ms) / megapixels);
    costs.per_million_pixels_ms = positive(pixels_ms - costs.per_million_shaded_ms);
    const double seen_ms = finest->draw_ms - *away_ms - megapixels * costs.per_million_shaded_ms;
    costs.per_million_seen_ms = positive(more_in_view > least_more_in_view
                                             ? std::min(seen_ms / (more_in_view * millions), per_million_ms / in_view)
                                             : 0.0);
    costs.per_million_triangles_ms = positive(per_million_ms - in_view * costs.per_million_seen_ms);
    costs.per_million_uploaded_ms = positive(finest->upload_ms / millions);
    costs.fixed_ms = positive(finest->draw_ms - millions * per_million_ms -
                              megapixels * (costs.per_million_pixels_ms + costs.per_million_shaded_ms));
    return costs;
}

Result<std::vector<control::FlownFrame>> fly(render::Renderer& renderer, const Scenery& scenery,
                                             const motion::Trace& trace, const PilotOptions& options) {
    const std::vector<control::Level> ladder =
        ladder_of(scenery, default_view(scenery, options.screen.fov_y_deg), display_of(options.screen));
    control::Flight flight{options.kind,    ladder,
                           options.control, static_cast<double>(options.screen.width) * options.screen.height,
                           options.budget,  Sight(scenery, options.screen)};
    Pilot pilot(renderer, scenery, options);
    return control::fly(flight, trace, [&](const control::FrameRequest& request) { return pilot.draw_frame(request); });
}

Result<render::Image> picture(render::Renderer& renderer, const Scenery& scenery, std::size_t level,
                              const std::vector<motion::Pose>& poses, const Screen& screen) {
    const auto parts = put(renderer, scenery, level);
    if (!parts) return parts.error();
    auto frame = draw(renderer, *parts, default_view(scenery, screen.fov_y_deg), screen, poses);
    if (!frame) return frame.error();
    return std::move(frame->image);
}

}  // namespace lodestream::fly
