#include "client/report/gather.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <set>
#include <thread>

#include "client/probe/graphics.h"
#include "client/render/image.h"
#include "client/report/hlod_study.h"
#include "client/report/linked.h"
#include "client/report/measure_frame_rate.h"
#include "client/report/pictures.h"
#include "client/report/points_study.h"
#include "client/report/shading_study.h"
#include "client/report/text.h"

namespace lodestream::report {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto poll_interval = std::chrono::milliseconds(250);
constexpr int polls_until_settled = 3;  // a server that imports a folder may queue assets after its first answer
constexpr double full_model_cpu_mhz = 1e9;
constexpr double difference_amplification = 8.0;
constexpr std::ptrdiff_t weak_devices = 2;  // the last of the classes: pda and phone

// How much to measure.
struct Effort {
    int runs;              // of a step, at most; the median counts
    double run_budget_ms;  // of all runs of a step together
    std::uint32_t frames;  // of a picture, at most
    double frame_budget_ms;
    std::size_t level_stride;
    int split_steps;
};
constexpr Effort normal_effort{7, 300.0, 15, 300.0, 1, 8};
constexpr Effort quick_effort{3, 60.0, 5, 60.0, 3, 4};

double ms_since(Clock::time_point start) {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return values.empty() ? 0.0 : values[(values.size() - 1) / 2];
}

// Median time of a call over several runs, and what the last run answered; the first failure ends it.
template <class Call>
auto timed(const Effort& effort, double& ms, Call call) {
    std::vector<double> times;
    const auto begin = Clock::now();
    for (;;) {
        const auto start = Clock::now();
        auto result = call();
        times.push_back(ms_since(start));
        const bool enough = static_cast<int>(times.size()) >= effort.runs || ms_since(begin) >= effort.run_budget_ms;
        if (!result || enough) {
            ms = median(std::move(times));
            return result;
        }
    }
}

std::string png_text(const render::Image& image) {
    Result<std::vector<std::byte>> png = image::encode_png(image);
    return png ? std::string(reinterpret_cast<const char*>(png->data()), png->size()) : std::string();
}

budget::Display display_of(const budget::Request& request) {
    return request.display.value_or(shading::default_display);
}

// Everything of the asset, all Gouraud: a device without limits asks.
proto::PlanRequest full_model_request(const std::string& asset) {
    proto::PlanRequest request;
    request.asset = asset;
    request.budget.device.cpu_mhz = full_model_cpu_mhz;
    request.budget.preference.target_fps = budget::min_target_fps;
    request.shading = proto::ShadingMode::gouraud;
    return request;
}

// The drawn view and what every device should see in it.
struct Reference {
    shading::View view;
    Box bounds;
    std::vector<render::Image> images;  // one a device class
    std::vector<Setting> settings;      // of the shading study
    std::optional<shading::ReferenceSurface> surface;
};

struct Fetched {
    codec::Decoded content;
    double fetch_ms = 0.0;
    double decode_ms = 0.0;
};

struct Drawn {
    render::Image image;
    double frame_ms = 0.0;
};

class Gatherer {
  public:
    Gatherer(sdk::Client& client, render::Renderer& renderer, const GatherOptions& options)
        : client_(client),
          renderer_(renderer),
          options_(options),
          effort_(options.quick ? quick_effort : normal_effort) {}

    Result<ReportData> run();

  private:
    Result<std::vector<proto::Asset>> settled_assets();
    std::vector<proto::Asset> choose(std::vector<proto::Asset> assets);
    Result<AssetResult> measure_asset(const proto::Asset& asset);
    Result<Reference> measure_full_model(AssetResult& result);
    Result<DeviceResult> measure_device(AssetResult& asset, std::size_t device, const Reference& reference);
    Result<LadderLevel> measure_level(const AssetResult& asset, std::size_t index, const Reference& reference);
    Status measure_split(AssetResult& asset, const Reference& reference);
    void probe_for(const proto::Asset& asset);
    void add_frame_rate();
    Result<ModeResult> measure_content(const proto::PlanResponse& plan, std::size_t device, const Reference& reference,
                                       render::Image* drawn = nullptr);
    Status measure_points(AssetResult& asset);
    Status save_pictures(AssetResult& asset, std::size_t device, const render::Image& level, const render::Image& full);
    Status save_composite(const AssetResult& asset);

    Result<Fetched> fetch(const std::string& url, std::uint64_t bytes);
    Result<Drawn> draw(const shading::View& view, const budget::Display& display);
    double predicted_ms(const codec::Decoded& content, const shading::View& view,
                        const budget::Display& display) const {
        return costs_ ? control::frame_ms(*costs_, probe::work_of(content, view, display)) : 0.0;
    }
    Result<ImageError> compare(const render::Image& full, const render::Image& level);
    std::string unique_stem(const std::string& name);
    Status begin(const std::string& step);
    void problem(const std::string& where, const Error& error) {
        data_.problems.push_back(where + ": " + error.message);
    }

    sdk::Client& client_;
    render::Renderer& renderer_;
    const GatherOptions& options_;
    Effort effort_;
    std::vector<DeviceClass> devices_;
    std::optional<control::FrameCosts> costs_;  // as the probe tells them
    std::vector<render::Image> composite_rows_;
    std::set<std::string> stems_;
    std::string stem_;  // of the asset at hand
    bool stopped_ = false;
    ReportData data_;
};

Status Gatherer::begin(const std::string& step) {
    stopped_ = stopped_ || !options_.progress(step);
    if (stopped_) return fail(ErrorCode::unavailable, "interrupted");
    return Nothing{};
}

std::string baking_text(const std::vector<proto::Asset>& assets) {
    std::string out = "baking";
    for (const proto::Asset& asset : assets)
        if (asset.status == proto::AssetStatus::baking)
            out += " " + asset.name + " " + std::to_string(static_cast<int>(100.0 * asset.progress)) + " %";
    return out;
}

Result<std::vector<proto::Asset>> Gatherer::settled_assets() {
    const auto is = [](proto::AssetStatus status) {
        return [status](const proto::Asset& a) { return a.status == status; };
    };
    int settled = 0;
    for (const auto start = Clock::now();;) {
        Result<std::vector<proto::Asset>> assets = client_.assets();
        if (!assets) return assets.error();
        const auto baking = std::count_if(assets->begin(), assets->end(), is(proto::AssetStatus::baking));
        const bool some_ready = std::any_of(assets->begin(), assets->end(), is(proto::AssetStatus::ready));
        settled = baking == 0 ? settled + 1 : 0;
        const double waited_s = ms_since(start) / 1e3;
        const bool late =
            waited_s > max_bake_wait_s || (options_.quick && some_ready && waited_s > max_quick_bake_wait_s);
        if (settled >= polls_until_settled || late) return assets;
        if (Status going_on = begin(baking_text(*assets)); !going_on) return going_on.error();
        std::this_thread::sleep_for(poll_interval);
    }
}

// The ready ones, small ones first where the report is quick; what is left out is said.
std::vector<proto::Asset> Gatherer::choose(std::vector<proto::Asset> assets) {
    std::vector<proto::Asset> chosen;
    if (options_.quick)
        std::stable_sort(assets.begin(), assets.end(),
                         [](const auto& a, const auto& b) { return a.triangles < b.triangles; });
    const std::size_t limit = options_.quick ? max_quick_assets : max_assets;
    for (const proto::Asset& asset : assets) {
        const auto leave_out = [&](const std::string& why) { data_.problems.push_back(asset.name + ": " + why); };
        if (asset.status == proto::AssetStatus::failed)
            leave_out("its bake failed: " + asset.error);
        else if (asset.status == proto::AssetStatus::baking)
            leave_out("still baking");
        else if (options_.quick && asset.triangles > max_quick_triangles)
            leave_out("larger than a quick report measures (" + format_count(max_quick_triangles) + " triangles)");
        else if (chosen.size() == limit)
            leave_out("more than the " + std::to_string(limit) +
                      (options_.quick ? " assets of a quick report" : " assets of a report"));
        else
            chosen.push_back(asset);
    }
    return chosen;
}

Result<Fetched> Gatherer::fetch(const std::string& url, std::uint64_t bytes) {
    Fetched out;
    Result<std::vector<std::byte>> glb = timed(effort_, out.fetch_ms, [&] { return client_.fetch(url, bytes); });
    if (!glb) return glb.error();
    Result<codec::Decoded> decoded = timed(effort_, out.decode_ms, [&] { return codec::decode_level(*glb); });
    if (!decoded) return decoded.error();
    out.content = *std::move(decoded);
    return out;
}

// Draws what is on the GPU: once to warm up, then as often as the effort allows.
Result<Drawn> Gatherer::draw(const shading::View& view, const budget::Display& display) {
    render::DrawOptions options;
    options.width = display.width;
    options.height = display.height;
    options.samples = 1;
    Result<render::Frame> frame = renderer_.draw(view, options);
    if (!frame) return frame.error();
    const auto runs = probe::timed_runs(renderer_, view, options, effort_.frame_budget_ms / 1000.0);
    if (!runs) return runs.error();
    return Drawn{std::move(frame->image), probe::timing_of(*runs).ms};
}

Result<ImageError> Gatherer::compare(const render::Image& full, const render::Image& level) {
    Result<render::Difference> difference = render::compare(full, level);
    if (!difference) return difference.error();
    return ImageError{100.0 * difference->rms / 255.0, difference->silhouette_percent};
}

Result<Reference> Gatherer::measure_full_model(AssetResult& result) {
    Result<proto::PlanResponse> plan = client_.plan(full_model_request(result.asset.id));
    if (!plan) return plan.error();
    Result<Fetched> full = fetch(plan->content.url, plan->content.bytes);
    if (!full) return full.error();
    result.full_triangles = plan->level.triangles;
    result.full_bytes = plan->content.bytes;
    result.full_decode_ms = full->decode_ms;

    Reference reference;
    reference.bounds = render::world_bounds(full->content);
    result.diagonal = reference.bounds.diagonal();
    reference.view = shading::framing_view(reference.bounds);
    if (Result<render::UploadStatistics> uploaded = renderer_.upload(full->content); !uploaded) return uploaded.error();
    for (const DeviceClass& device : devices_) {
        Result<Drawn> drawn = draw(reference.view, display_of(device.request.budget));
        if (!drawn) return drawn.error();
        reference.images.push_back(std::move(drawn->image));
    }
    Result<std::vector<Setting>> settings = study_settings(renderer_, reference.view, options_.quick);
    if (!settings) return settings.error();
    reference.settings = *std::move(settings);
    result.operations = count_operations(full->content, reference.view);
    reference.surface = reference_surface(full->content);
    return reference;
}

Result<ModeResult> Gatherer::measure_content(const proto::PlanResponse& plan, std::size_t device,
                                             const Reference& reference, render::Image* picture) {
    Result<Fetched> fetched = fetch(plan.content.url, plan.content.bytes);
    if (!fetched) return fetched.error();
    Result<render::UploadStatistics> uploaded = renderer_.upload(fetched->content);
    if (!uploaded) return uploaded.error();
    Result<Drawn> drawn = draw(reference.view, display_of(devices_[device].request.budget));
    if (!drawn) return drawn.error();
    Result<ImageError> error = compare(reference.images[device], drawn->image);
    if (!error) return error.error();
    if (picture) *picture = std::move(drawn->image);

    ModeResult out;
    out.gouraud = plan.shading.gouraud;
    out.flat = plan.shading.flat;
    out.bytes = plan.content.bytes;
    out.fetch_ms = fetched->fetch_ms;
    out.decode_ms = fetched->decode_ms;
    out.frame_ms = drawn->frame_ms;
    out.predicted_ms = predicted_ms(fetched->content, reference.view, display_of(devices_[device].request.budget));
    out.gpu_bytes = uploaded->geometry_bytes + uploaded->texture_bytes;
    out.image = *error;
    return out;
}

Result<DeviceResult> Gatherer::measure_device(AssetResult& asset, std::size_t device, const Reference& reference) {
    proto::PlanRequest request = devices_[device].request;
    request.asset = asset.asset.id;
    request.view = reference.view;
    request.profile = proto::Profile::lean;

    DeviceResult out;
    out.device = devices_[device].name;
    out.request = request.budget;
    render::Image picture;
    constexpr proto::ShadingMode modes[] = {proto::ShadingMode::hybrid, proto::ShadingMode::gouraud,
                                            proto::ShadingMode::flat};
    for (std::size_t i = 0; i < out.modes.size(); ++i) {
        request.shading = modes[i];
        Result<proto::PlanResponse> plan = client_.plan(request);
        if (!plan) return plan.error();
        Result<ModeResult> result = measure_content(*plan, device, reference, i == 0 ? &picture : nullptr);
        if (!result) return result.error();
        out.modes[i] = *result;
        out.modes[i].mode = modes[i];
        if (i == 0) out.plan = *std::move(plan);
    }
    for (const proto::LeftOut& item : out.plan.left_out) out.left_out_bytes += item.bytes;

    request.shading = proto::ShadingMode::hybrid;
    out.sent_request = request;
    request.profile = proto::Profile::plain;
    const Result<proto::PlanResponse> plain = client_.plan(request);
    if (!plain) return plain.error();
    out.plain_bytes = plain->content.bytes;
    if (auto again = timed(effort_, out.replan_ms, [&] { return client_.plan(out.sent_request); }); !again)
        return again.error();
    if (Status saved = save_pictures(asset, device, picture, reference.images[device]); !saved) return saved.error();
    return out;
}

Result<LadderLevel> Gatherer::measure_level(const AssetResult& asset, std::size_t index, const Reference& reference) {
    LadderLevel out;
    out.index = index;
    out.level = asset.asset.levels[index];
    Result<Fetched> fetched = fetch(out.level.url, out.level.bytes);
    if (!fetched) return fetched.error();
    out.fetch_ms = fetched->fetch_ms;
    out.decode_ms = fetched->decode_ms;
    Result<render::UploadStatistics> uploaded = renderer_.upload(fetched->content);
    if (!uploaded) return uploaded.error();
    out.gouraud = uploaded->gouraud_triangles;
    for (std::size_t device = 0; device < devices_.size(); ++device) {
        const budget::Display display = display_of(devices_[device].request.budget);
        Result<Drawn> drawn = draw(reference.view, display);
        if (!drawn) return drawn.error();
        Result<ImageError> error = compare(reference.images[device], drawn->image);
        if (!error) return error.error();
        const double pixels = shading::pixels_per_unit(reference.view, reference.bounds, display);
        out.drawn.push_back({devices_[device].name, drawn->frame_ms, out.level.max_error * pixels, *error,
                             predicted_ms(fetched->content, reference.view, display)});
    }
    return out;
}

// Plans for eyes ever farther away, from the bounding sphere to where the object counts as farthest, and draws all of
// them in the one view of the reference: only the split differs.
Status Gatherer::measure_split(AssetResult& asset, const Reference& reference) {
    constexpr std::size_t device = 0;
    proto::PlanRequest request = devices_[device].request;
    request.asset = asset.asset.id;
    request.profile = proto::Profile::lean;
    asset.split_device = devices_[device].name;
    const double tangent = std::tan(radians(reference.view.fov_y_deg) / 2.0);
    const double farthest = display_of(request.budget).height / (shading::far_diameter_px * tangent);  // radii
    const Vec3d center = reference.bounds.center();
    const Vec3d direction = normalize(reference.view.eye - center);
    for (int step = 0; step <= effort_.split_steps; ++step) {
        const double radii = std::pow(farthest, static_cast<double>(step) / effort_.split_steps);
        request.view = reference.view;
        request.view->target = center;
        request.view->eye = center + direction * (reference.bounds.radius() * radii);
        Result<proto::PlanResponse> plan = client_.plan(request);
        if (!plan) return plan.error();
        if (!asset.split.empty() && asset.split.back().distance == plan->shading.distance) continue;
        Result<ModeResult> result = measure_content(*plan, device, reference);
        if (!result) return result.error();
        asset.split.push_back({plan->shading.distance, plan->level.triangles, *result});
    }
    return Nothing{};
}

// Of the two weakest classes, which points are for.
Status Gatherer::measure_points(AssetResult& asset) {
    PointsStudyOptions options;
    options.devices.assign(devices_.end() - std::min<std::ptrdiff_t>(std::ssize(devices_), weak_devices),
                           devices_.end());
    options.directions = options_.quick ? 1 : 3;
    options.frames = effort_.frames;
    options.going_on = [&] { return static_cast<bool>(begin(asset.asset.name + ": points")); };
    return study_points(client_, renderer_, options, asset);
}

Status Gatherer::save_pictures(AssetResult& asset, std::size_t device, const render::Image& level,
                               const render::Image& full) {
    Result<render::Image> difference = render::difference_image(full, level, difference_amplification);
    if (!difference) return difference.error();
    const render::Image panels[] = {level, full, *std::move(difference)};
    Picture picture{devices_[device].name,
                    level.width,
                    level.height,
                    {},
                    {},
                    {},
                    std::filesystem::path("pictures") / (stem_ + "-" + devices_[device].name + ".png")};
    if (Status written = render::write_png(options_.out / picture.file, render::side_by_side(panels)); !written)
        return written;

    const Rectangle part = shown_part(std::span(panels).first(2), level.width / 40);
    std::vector<render::Image> row;
    for (const render::Image& panel : panels) row.push_back(scaled_down(cropped(panel, part), composite_width));
    composite_rows_.push_back(render::side_by_side(row));
    picture.level_png = png_text(scaled_down(row[0], thumbnail_width));
    picture.full_png = png_text(scaled_down(row[1], thumbnail_width));
    picture.difference_png = png_text(scaled_down(row[2], thumbnail_width));
    asset.pictures.push_back(std::move(picture));
    return Nothing{};
}

Status Gatherer::save_composite(const AssetResult& asset) {
    if (asset.pictures.empty()) return Nothing{};
    return render::write_png(options_.out / "pictures" / (stem_ + ".png"), stacked(composite_rows_));
}

Result<AssetResult> Gatherer::measure_asset(const proto::Asset& listed) {
    AssetResult result;
    Result<proto::Asset> details = client_.asset(listed.id);
    if (!details) return details.error();
    result.asset = *std::move(details);
    stem_ = unique_stem(result.asset.name);
    composite_rows_.clear();

    if (Status going_on = begin(listed.name + ": full model"); !going_on) return going_on.error();
    Result<Reference> reference = measure_full_model(result);
    if (!reference) return reference.error();

    for (std::size_t device = 0; device < devices_.size(); ++device) {
        if (Status going_on = begin(listed.name + ": " + devices_[device].name); !going_on) return going_on.error();
        Result<DeviceResult> measured = measure_device(result, device, *reference);
        if (measured)
            result.devices.push_back(*std::move(measured));
        else
            problem(listed.name + " on " + devices_[device].name, measured.error());
    }
    const std::size_t levels = std::min(result.asset.levels.size(), max_levels);
    for (std::size_t index = 0; index < levels; index += effort_.level_stride) {
        if (Status going_on = begin(listed.name + ": level " + std::to_string(index) + " of " + std::to_string(levels));
            !going_on)
            return going_on.error();
        Result<LadderLevel> level = measure_level(result, index, *reference);
        if (level)
            result.ladder.push_back(*std::move(level));
        else
            problem(listed.name + ", level " + std::to_string(index), level.error());
    }
    if (Status going_on = begin(listed.name + ": split"); !going_on) return going_on.error();
    if (Status split = measure_split(result, *reference); !split) problem(listed.name + ", split", split.error());
    if (Status going_on = begin(listed.name + ": shading"); !going_on) return going_on.error();
    const StudyOptions study{result.asset.id, reference->view, effort_.frames, options_.quick};
    if (Status studied = study_shading(client_, renderer_, reference->settings, *reference->surface, study, result);
        !studied)
        problem(listed.name + ", shading", studied.error());
    if (result.asset.hierarchy) {
        if (Status going_on = begin(listed.name + ": tiles"); !going_on) return going_on.error();
        proto::PlanRequest request = full_model_request(result.asset.id);
        request.view = reference->view;
        if (Status studied = study_hlod(client_, renderer_, request, reference->images.front(), effort_.frames, result);
            !studied)
            problem(listed.name + ", tiles", studied.error());
    }
    if (Status going_on = begin(listed.name + ": points"); !going_on) return going_on.error();
    if (Status studied = measure_points(result); !studied) problem(listed.name + ", points", studied.error());
    if (Status saved = save_composite(result); !saved) problem(listed.name, saved.error());
    if (result.devices.empty()) return fail(ErrorCode::unavailable, "no device class could be measured");
    return result;
}

// Anew for each model: a machine that others use is not equally fast all the time.
void Gatherer::probe_for(const proto::Asset& asset) {
    if (!begin(asset.name + ": probe")) return;
    const Result<probe::Graphics> graphics = probe::measure_graphics(renderer_);
    costs_ = graphics ? std::optional(graphics->costs) : std::nullopt;
    if (!graphics) problem(asset.name + ", probe", graphics.error());
}

void Gatherer::add_frame_rate() {
    const auto progress = [&](const std::string& step) { return static_cast<bool>(begin(step)); };
    Result<FrameRateResult> result = measure_frame_rate(client_, renderer_, {options_.quick, progress});
    if (result)
        data_.frame_rate = *std::move(result);
    else
        problem("frame rate", result.error());
}

std::string Gatherer::unique_stem(const std::string& name) {
    const std::string stem = file_stem(name);
    std::string unique = stem;
    for (int i = 2; !stems_.insert(unique).second; ++i) unique = stem + "-" + std::to_string(i);
    return unique;
}

Result<ReportData> Gatherer::run() {
    Result<std::vector<DeviceClass>> devices = device_classes();
    if (!devices) return devices.error();
    devices_ = *std::move(devices);
    Result<std::vector<proto::Asset>> assets = settled_assets();
    if (!assets) return assets.error();
    const std::vector<proto::Asset> chosen = choose(*std::move(assets));
    if (chosen.size() > max_thorough_assets) {
        effort_ = quick_effort;
        data_.problems.push_back(std::to_string(chosen.size()) +
                                 " models: each is measured with fewer levels and frames");
    }
    for (const proto::Asset& asset : chosen) {
        probe_for(asset);
        Result<AssetResult> measured = measure_asset(asset);
        if (stopped_) return fail(ErrorCode::unavailable, "interrupted");
        if (measured)
            data_.assets.push_back(*std::move(measured));
        else
            problem(asset.name, measured.error());
    }
    if (data_.assets.empty())
        return fail(ErrorCode::not_found,
                    "nothing could be measured: " +
                        (data_.problems.empty() ? "the server has no assets" : data_.problems.front()));
    if (Status going_on = begin("links"); going_on)
        if (Status linked =
                measure_links(options_.server_url, options_.quick ? max_quick_link_s : max_link_s, data_.assets);
            !linked)
            problem("links", linked.error());
    add_frame_rate();
    if (stopped_) return fail(ErrorCode::unavailable, "interrupted");
    return std::move(data_);
}

}  // namespace

Result<ReportData> gather(sdk::Client& client, render::Renderer& renderer, const GatherOptions& options) {
    return Gatherer(client, renderer, options).run();
}

}  // namespace lodestream::report
