#include "tests/bench/point_choice.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "client/render/renderer.h"
#include "client/report/device_classes.h"
#include "client/report/points_study.h"
#include "common/base/directions.h"
#include "common/codec/points_codec.h"
#include "server/planner/planner.h"
#include "server/store/store.h"
#include "tests/bench/value_of.h"

namespace lodestream::bench {
namespace {

constexpr std::uint64_t max_content_bytes = 1ull << 30;
constexpr double unlimited_mhz = 1e9;

class ChoiceBench {
  public:
    explicit ChoiceBench(const std::filesystem::path& folder)
        : store_(value_of(store::Store::open(folder))),
          full_(value_of(render::Renderer::create())),
          level_(value_of(render::Renderer::create())) {}

    void run(std::vector<proto::PointsChoice>& choices, const std::function<void()>& keep) {
        for (const proto::Asset& asset : value_of(store_.assets())) {
            if (asset.status != proto::AssetStatus::ready || asset.hierarchy) continue;
            upload_full(asset);
            for (const report::DeviceClass& device : value_of(report::device_classes())) {
                if (std::ranges::count(choice_devices, device.name) == 0) continue;
                for (const double distance : report::choice_distances) compare_at(asset, device, distance, choices);
            }
            keep();
        }
    }

  private:
    std::vector<std::byte> bytes_of(const proto::PlanResponse& plan) const {
        const std::string hash = plan.content.url.substr(plan.content.url.rfind('/') + 1, 64);
        return value_of(store::read_file(value_of(store_.file(hash, "glb")).path, max_content_bytes));
    }

    void upload_full(const proto::Asset& asset) {
        proto::PlanRequest request;
        request.asset = asset.id;
        request.budget.device.cpu_mhz = unlimited_mhz;
        request.budget.preference.target_fps = budget::min_target_fps;
        request.shading = proto::ShadingMode::gouraud;
        const codec::Decoded content = value_of(codec::decode_level(bytes_of(value_of(planner_.plan(request)))));
        value_of(full_.upload(content));
        bounds_ = render::world_bounds(content);
    }

    static double triangles_per_second(const proto::PlanRequest& request) {
        return budget::capacity_mhz(request.budget.device) / budget::reference_capacity_mhz *
               budget::reference_triangles_per_second;
    }

    // The device's rates whatever the model has: what the reference drew is told instead of worked out.
    static proto::PlanRequest request_of(const proto::Asset& asset, const report::DeviceClass& device, double rate,
                                         double share) {
        proto::PlanRequest request = device.request;
        budget::Request& asked = request.budget;
        request.asset = asset.id;
        asked.device.name = device.name;
        asked.network.reset();
        asked.preference.quality = share;
        asked.reference.triangles =
            static_cast<std::uint64_t>(budget::reference_triangles_per_second / asked.preference.target_fps);
        asked.device.points_per_second = rate * triangles_per_second(request);
        return request;
    }

    shading::View view_at(double distance, std::size_t direction) const {
        shading::View view = shading::framing_view(bounds_);
        const Vec3d away =
            direction == 0 ? normalize(view.eye - bounds_.center()) : spread_direction(direction, choice_views);
        view.target = bounds_.center();
        view.eye = view.target + away * (distance * bounds_.radius());
        return view;
    }

    // What each rate and share gets from there. The full model's pictures serve all of them, those of triangles all
    // rates.
    void compare_at(const proto::Asset& asset, const report::DeviceClass& device, double distance,
                    std::vector<proto::PointsChoice>& choices) {
        full_pictures_.clear();
        for (std::size_t direction = 0; direction < choice_views; ++direction)
            full_pictures_.push_back(picture(full_, view_at(distance, direction), *device.request.budget.display));
        for (const double share : frame_shares) {
            proto::PlanRequest request = request_of(asset, device, point_rates[0], share);
            const Shown triangles = show(request, proto::Primitives::triangles, distance);
            for (const double rate : point_rates) {
                request.budget.device.points_per_second = rate * triangles_per_second(request);
                const Shown points = show(request, proto::Primitives::points, distance);
                proto::PointsChoice choice;
                choice.model = asset.name;
                choice.device = device.name;
                choice.points_per_triangle = rate;
                choice.frame_share = share;
                choice.distance = distance;
                choice.triangles = triangles.count;
                choice.points = points.count;
                choice.triangles_percent = triangles.percent;
                choice.points_percent = points.percent;
                add_plan(request, distance, choice);
                choices.push_back(choice);
            }
        }
    }

    void add_plan(proto::PlanRequest request, double distance, proto::PointsChoice& choice) {
        request.primitives = proto::Primitives::any;
        request.view = view_at(distance, 0);
        const proto::PlanResponse plan = value_of(planner_.plan(request));
        choice.chose_points = plan.level.points > 0;
        if (plan.crossing && plan.crossing->distance) choice.crossing = *plan.crossing->distance / bounds_.radius();
    }

    struct Shown {
        std::uint64_t count = 0;  // triangles or points, from the first direction
        double percent = 0.0;     // RMS over the pixels that the full model covers, from all
    };

    Shown show(proto::PlanRequest request, proto::Primitives primitives, double distance) {
        request.primitives = primitives;
        Shown shown;
        double squares = 0.0, covered = 0.0;
        for (std::size_t direction = 0; direction < choice_views; ++direction) {
            request.view = view_at(distance, direction);
            const proto::PlanResponse plan = value_of(planner_.plan(request));
            const std::vector<std::byte> bytes = bytes_of(plan);
            value_of(plan.level.points > 0 ? level_.upload(value_of(codec::decode_points(bytes)).content)
                                           : level_.upload(value_of(codec::decode_level(bytes))));
            if (direction == 0) shown.count = plan.level.points + plan.level.triangles;
            const render::Image& full = full_pictures_[direction];
            const auto off = value_of(render::compare(full, picture(level_, *request.view, *request.budget.display)));
            squares += off.rms * off.rms * static_cast<double>(off.compared_pixels);
            covered += static_cast<double>(value_of(render::compare(full, full)).compared_pixels);
        }
        shown.percent = covered > 0.0 ? 100.0 / 255.0 * std::sqrt(squares / covered) : 0.0;
        return shown;
    }

    static render::Image picture(render::Renderer& renderer, const shading::View& view,
                                 const budget::Display& display) {
        render::DrawOptions drawing;
        drawing.width = display.width;
        drawing.height = display.height;
        drawing.samples = 1;
        return value_of(renderer.draw(view, drawing)).image;
    }

    store::Store store_;
    planner::Planner planner_{store_};
    render::Renderer full_, level_;
    Box bounds_;                                // of the full model
    std::vector<render::Image> full_pictures_;  // of it, from each direction at one distance
};

}  // namespace

void study_choices(const std::filesystem::path& store, std::vector<proto::PointsChoice>& choices,
                   const std::function<void()>& keep) {
    ChoiceBench(store).run(choices, keep);
}

}  // namespace lodestream::bench
