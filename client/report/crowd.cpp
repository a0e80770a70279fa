#include "client/report/crowd.h"

#include <algorithm>
#include <cmath>

#include "common/base/directions.h"

namespace lodestream::report {
namespace {

double share(std::uint64_t part, std::uint64_t missing) {
    return part + missing == 0 ? 1.0 : static_cast<double>(part) / static_cast<double>(part + missing);
}

std::size_t level_at(double distance_radii) {
    std::size_t level = 0;
    while (level + 1 < crowd_levels && distance_radii >= level_distances[level + 1]) ++level;
    return level;
}

double eye_distance(const CrowdModel& model, const Vec3d& offset, const Vec3d& eye) {
    return glm::length(model.bounds.center() + offset - eye) / model.bounds.radius();
}

// How far the next coarser level has come: 0 up to level_fade before its distance, 1 from there on.
double coming(std::size_t level, double distance_radii) {
    if (level + 1 == crowd_levels) return 0.0;
    const double next = level_distances[level + 1];
    return std::clamp(1.0 - (next - distance_radii) / (level_fade * next), 0.0, 1.0);
}

void add_instance(const CrowdModel& model, const Vec3d& offset, const Vec3d& eye, LevelChange change,
                  std::vector<render::Instance>& crowd) {
    const double distance = eye_distance(model, offset, eye);
    const std::size_t level = level_at(distance);
    const double next = change == LevelChange::fading ? coming(level, distance) : 0.0;
    crowd.push_back({offset, model.levels[level], {next, 1.0}});
    if (next > 0.0) crowd.push_back({offset, model.levels[level + 1], {0.0, next}});
}

// Of the same instances; a crowd's is what any of its parts covers.
struct Silhouettes {
    Mask full, points;

    void join(const Silhouettes& part) {
        full.join(part.full);
        points.join(part.points);
    }
    SilhouetteScore score() const { return match(points, full); }
};

class Scorer {
  public:
    Scorer(CrowdModel& model, const CrowdOptions& options)
        : model_(model), options_(options), drawing_(silhouette_options(options.canvas)) {}

    Status add_view(const shading::View& view) {
        const std::array<std::uint32_t, 3> sides{options_.side, options_.side, options_.side};
        std::array<std::vector<render::Instance>, crowd_levels> parts;
        for (const render::Instance& instance : crowd_of(model_, sides, view.eye))
            parts[level_at(eye_distance(model_, instance.offset, view.eye))].push_back(instance);
        const Mask nothing(options_.canvas.width, options_.canvas.height);
        Silhouettes crowd{nothing, nothing};
        for (std::size_t level = 0; level < crowd_levels; ++level) {
            if (parts[level].empty()) continue;
            score_.instances[level] += parts[level].size();
            const auto part = draw(view, parts[level]);
            if (!part) return part.error();
            score_.by_level[level].add(part->score());
            crowd.join(*part);
        }
        score_.all.add(crowd.score());
        return Nothing{};
    }
    const CrowdScore& score() const { return score_; }

  private:
    Result<Silhouettes> draw(const shading::View& view, const std::vector<render::Instance>& instances) {
        Mask full(options_.canvas.width, options_.canvas.height);
        const Mat4d pixels = render::pixels_from_world(view, full.width(), full.height());
        for (const render::Instance& instance : instances) model_.full.cover(pixels, instance.offset, full);
        drawing_.instances = instances;
        const Result<render::Frame> points = model_.points.draw(view, drawing_);
        if (!points) return points.error();
        return Silhouettes{std::move(full), silhouette(points->image)};
    }

    CrowdModel& model_;
    CrowdOptions options_;
    render::DrawOptions drawing_;
    CrowdScore score_;
};

}  // namespace

render::DrawOptions silhouette_options(const budget::Display& canvas) {
    render::DrawOptions options;
    options.width = canvas.width;
    options.height = canvas.height;
    options.samples = 1;
    options.phong = {0.0, 0.0, 0.0, 1.0};
    return options;
}

double SilhouetteScore::recall() const {
    return share(both, full_alone);
}
double SilhouetteScore::precision() const {
    return share(both, points_alone);
}
double SilhouetteScore::f_measure() const {
    const double sum = recall() + precision();
    return sum > 0.0 ? 2.0 * recall() * precision() / sum : 0.0;
}
void SilhouetteScore::add(const SilhouetteScore& other) {
    both += other.both;
    points_alone += other.points_alone;
    full_alone += other.full_alone;
}

SilhouetteScore match(const Mask& points, const Mask& full) {
    const std::uint64_t both = full.count_shared(points);
    return {both, points.count() - both, full.count() - both};
}

std::vector<render::Instance> crowd_of(const CrowdModel& model, const std::array<std::uint32_t, 3>& sides,
                                       const Vec3d& eye, LevelChange change) {
    std::vector<render::Instance> crowd;
    const double step = crowd_spacing * model.bounds.radius();
    const auto place = [&](std::uint32_t i, int axis) { return step * (i - 0.5 * (sides[axis] - 1.0)); };
    for (std::uint32_t x = 0; x < sides[0]; ++x)
        for (std::uint32_t y = 0; y < sides[1]; ++y)
            for (std::uint32_t z = 0; z < sides[2]; ++z)
                add_instance(model, {place(x, 0), place(y, 1), place(z, 2)}, eye, change, crowd);
    return crowd;
}

Result<CrowdScore> score_crowd(CrowdModel& model, const CrowdOptions& options, const std::function<bool()>& going_on) {
    const double reach = std::sqrt(3.0) * 0.5 * (options.side - 1.0) * crowd_spacing + 1.0;
    if (!(reach < orbit_distances.front())) return invalid_input("the crowd reaches the camera's nearest orbit");
    Scorer scorer(model, options);
    shading::View view;
    view.target = model.bounds.center();
    for (const double orbit : orbit_distances)
        for (std::size_t i = 0; i < options.directions; ++i) {
            if (going_on && !going_on()) return fail(ErrorCode::unavailable, "interrupted");
            view.eye = view.target + spread_direction(i, options.directions) * (orbit * model.bounds.radius());
            if (Status added = scorer.add_view(view); !added) return added.error();
        }
    return scorer.score();
}

}  // namespace lodestream::report
