#include "client/report/points_study.h"

#include <algorithm>
#include <cmath>

#include "client/report/crowd.h"

namespace lodestream::report {
namespace {

constexpr double unlimited_mhz = 1e9;
constexpr std::array<const char*, crowd_levels> level_names{"L0", "L1", "L2", "L3", "L4"};
constexpr budget::Display largest_display{16'384, 16'384};

// All that there is of the asset, as triangles or as points.
proto::PlanRequest whole(const proto::Asset& asset, proto::Primitives primitives) {
    proto::PlanRequest request;
    request.asset = asset.id;
    request.budget.device.cpu_mhz = unlimited_mhz;
    request.budget.preference.target_fps = budget::min_target_fps;
    request.shading = proto::ShadingMode::gouraud;
    request.primitives = primitives;
    if (primitives == proto::Primitives::points) request.budget.display = largest_display;
    return request;
}

// As many instances a side as their points allow.
std::uint32_t crowd_side(std::uint64_t points) {
    const double instances =
        static_cast<double>(max_crowd_points) / static_cast<double>(std::max<std::uint64_t>(points, 1));
    return static_cast<std::uint32_t>(std::clamp(std::floor(std::cbrt(instances)), 1.0, double{max_crowd_side}));
}

PointsLevel level_result(const std::string& name, std::uint64_t points, const SilhouetteScore& score) {
    return {name, points, score.recall(), score.precision(), score.f_measure()};
}

Status score_levels(CrowdModel& model, const PointsStudyOptions& options, AssetResult& asset) {
    CrowdOptions crowd;
    crowd.side = crowd_side(model.levels.front());
    crowd.directions = options.directions;
    const Result<CrowdScore> score = score_crowd(model, crowd, options.going_on);
    if (!score) return score.error();
    asset.crowd_instances = crowd.side * crowd.side * crowd.side;
    for (std::size_t level = 0; level < crowd_levels; ++level)
        if (score->instances[level] > 0)
            asset.points.push_back(level_result(level_names[level], model.levels[level], score->by_level[level]));
    asset.points.push_back(level_result("all", 0, score->all));
    return Nothing{};
}

class ChoiceStudy {
  public:
    ChoiceStudy(sdk::Client& client, render::Renderer& full, render::Renderer& other, const Box& bounds,
                const PointsStudyOptions& options, AssetResult& asset)
        : client_(client), full_(full), other_(other), bounds_(bounds), options_(options), asset_(asset) {}

    Status run() {
        for (const DeviceClass& device : options_.devices)
            for (const double distance : choice_distances) {
                if (options_.going_on && !options_.going_on()) return fail(ErrorCode::unavailable, "interrupted");
                if (Status compared = compare_at(device, distance); !compared) return compared;
            }
        return Nothing{};
    }

  private:
    Status compare_at(const DeviceClass& device, double distance) {
        proto::PlanRequest request = device.request;
        request.asset = asset_.asset.id;
        request.view = shading::framing_view(bounds_);
        const Vec3d away = normalize(request.view->eye - bounds_.center());
        request.view->target = bounds_.center();
        request.view->eye = bounds_.center() + away * (distance * bounds_.radius());
        drawing_.width = request.budget.display.value_or(shading::default_display).width;
        drawing_.height = request.budget.display.value_or(shading::default_display).height;
        drawing_.samples = 1;
        drawing_.frames = 1;
        const Result<render::Frame> full = full_.draw(*request.view, drawing_);
        if (!full) return full.error();
        drawing_.frames = std::max(1u, options_.frames);

        PointsChoice choice{device.name, distance, {}, {}, false};
        for (const bool as_points : {false, true}) {
            request.primitives = as_points ? proto::Primitives::points : proto::Primitives::triangles;
            const Result<Shown> shown = show(request, full->image);
            if (!shown) return shown.error();
            (as_points ? choice.points : choice.triangles) = *shown;
        }
        request.primitives = proto::Primitives::any;
        const Result<proto::PlanResponse> any = client_.plan(request);
        if (!any) return any.error();
        choice.chose_points = any->level.points > 0;
        asset_.choices.push_back(choice);
        return Nothing{};
    }

    Result<Shown> show(const proto::PlanRequest& request, const render::Image& full) {
        const Result<sdk::Loaded> loaded = client_.load(request);
        if (!loaded) return loaded.error();
        const auto uploaded = loaded->points ? other_.upload(*loaded->points) : other_.upload(loaded->content);
        if (!uploaded) return uploaded.error();
        const Result<render::Frame> frame = other_.draw(*request.view, drawing_);
        if (!frame) return frame.error();
        const Result<render::Difference> difference = render::compare(full, frame->image);
        if (!difference) return difference.error();
        return Shown{uploaded->triangles + uploaded->points,
                     loaded->bytes,
                     frame->frame_ms,
                     {100.0 * difference->rms / 255.0, difference->silhouette_percent}};
    }

    sdk::Client& client_;
    render::Renderer& full_;
    render::Renderer& other_;
    const Box bounds_;
    const PointsStudyOptions& options_;
    AssetResult& asset_;
    render::DrawOptions drawing_;
};

}  // namespace

Status study_points(sdk::Client& client, render::Renderer& renderer, const PointsStudyOptions& options,
                    AssetResult& asset) {
    const Result<sdk::Loaded> full = client.load(whole(asset.asset, proto::Primitives::triangles));
    if (!full) return full.error();
    const Result<sdk::Loaded> points = client.load(whole(asset.asset, proto::Primitives::points));
    if (!points) return points.error();
    Result<render::Renderer> other = render::Renderer::create();
    if (!other) return other.error();
    if (auto uploaded = renderer.upload(full->content); !uploaded) return uploaded.error();
    if (auto uploaded = other->upload(*points->points); !uploaded) return uploaded.error();

    const SilhouetteTree silhouettes(full->content);
    CrowdModel model{silhouettes, *other, render::world_bounds(full->content), {}};
    double count = static_cast<double>(points->plan.level.points);
    for (std::uint64_t& level : model.levels) {
        level = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(count));
        count *= level_ratio;
    }
    if (Status scored = score_levels(model, options, asset); !scored) return scored;
    return ChoiceStudy(client, renderer, *other, model.bounds, options, asset).run();
}

}  // namespace lodestream::report
