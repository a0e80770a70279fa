// A report's data without a server: one asset, the device classes by name, plain numbers.
#pragma once

#include "client/report/data.h"

namespace lodestream::report::testing {

inline ModeResult mode_result(proto::ShadingMode mode, std::uint64_t bytes, double image_error_percent) {
    ModeResult out;
    out.mode = mode;
    out.gouraud = mode == proto::ShadingMode::flat ? 0 : 60;
    out.flat = 100 - out.gouraud;
    out.bytes = bytes;
    out.fetch_ms = 1.0;
    out.decode_ms = 2.0;
    out.frame_ms = 3.0;
    out.image.percent = image_error_percent;
    return out;
}

inline DeviceResult device_result(const std::string& name, double cpu_mhz) {
    DeviceResult out;
    out.device = name;
    out.request.device.cpu_mhz = cpu_mhz;
    out.request.display = budget::Display{320, 240};
    out.plan.dlr = cpu_mhz / 3400.0;
    out.plan.ncp = 110;
    out.plan.budget.triangles = 100;
    out.plan.budget.limited_by = "device";
    out.plan.level.triangles = 100;
    out.plan.level.rms_error_percent = 0.5;
    out.plan.content.bytes = 900;
    out.plan.timing_ms.cut = 0.25;
    out.replan_ms = 0.5;
    out.modes = {mode_result(proto::ShadingMode::hybrid, 900, 2.0), mode_result(proto::ShadingMode::gouraud, 1000, 1.0),
                 mode_result(proto::ShadingMode::flat, 800, 3.0)};
    return out;
}

inline AssetResult asset_result(const std::string& name) {
    AssetResult out;
    out.asset.name = name;
    out.asset.triangles = 6400;
    out.asset.bake_ms = 120.0;
    out.diagonal = 2.0;
    out.full_triangles = 6400;
    out.full_bytes = 40'000;
    out.devices = {device_result("desktop", 2460.0), device_result("phone", 70.0)};
    for (std::uint64_t i = 0; i < 3; ++i) {
        LadderLevel rung;
        rung.index = i;
        rung.level.triangles = 6400u >> i;
        rung.level.rms_error = 0.01 * static_cast<double>(i);
        rung.level.max_error = 0.02 * static_cast<double>(i);
        rung.level.rms_error_percent = 0.5 * static_cast<double>(i);
        rung.level.bytes = 40'000u >> i;
        rung.level.encode_ms = 8.0 / static_cast<double>(i + 1);
        for (const DeviceResult& device : out.devices)
            rung.drawn.push_back({device.device, 4.0, 0.5, {0.1 * static_cast<double>(i), 0.0}});
        out.ladder.push_back(rung);
    }
    out.asset.hierarchy = proto::Hierarchy{12, 3, 2'000, 9'000, 0.5, 40.0};
    out.points = {{"L0", 500, 0.97, 0.99, 0.98}, {"all", 0, 0.95, 0.97, 0.96}};
    out.crowd_instances = 27;
    out.choices = {{"phone", 1.5, {100, 900, 1.0, {3.0, 1.0}}, {100, 1'600, 1.0, {9.0, 4.0}}, false},
                   {"phone", 96.0, {100, 900, 1.0, {0.5, 0.0}}, {20, 400, 0.5, {0.4, 0.0}}, true}};
    out.hlod = {{480, 470, 1, 900, 9.0, 1.5, {6.0, 2.0}}, {1'920, 1'900, 4, 3'000, 3.0, 2.5, {2.0, 0.5}}};
    out.plans = {{480, 480, 0, 950, 8.0, 1.5, {5.5, 1.9}}};
    out.split_device = "desktop";
    for (const double d : {0.0, 0.5, 1.0})
        out.split.push_back(
            {d, 100, mode_result(proto::ShadingMode::hybrid, 1000 - static_cast<std::uint64_t>(200 * d), d)});
    out.operations = {6400, 3000, 57'600, 64'000, 83'200, 64'537, 75'463};
    for (const auto& [share, error] : {std::pair{0.25, 2.0}, std::pair{0.875, 1.5}, std::pair{1.0, 3.0}}) {
        ShadingSample sample;
        sample.series = "equal operations";
        sample.criterion = "measured importance";
        sample.share_of_price = share;
        sample.is_chosen = share == 0.875;
        sample.operations = 400;
        sample.result = mode_result(proto::ShadingMode::hybrid, 0, error);
        out.shading.push_back(sample);
    }
    for (const auto& [d, frame_ms] : {std::pair{0.0, 8.0}, std::pair{1.0, 4.0}}) {
        ShadingSample sample;
        sample.series = "lights";
        sample.criterion = "importance from anywhere";
        sample.lights = 4;
        sample.display = {800, 600};
        sample.triangles_per_pixel = 0.5;
        sample.distance = d;
        sample.result = mode_result(proto::ShadingMode::hybrid, 0, d);
        sample.result.frame_ms = frame_ms;
        out.shading.push_back(sample);
    }
    out.pictures = {{"phone", 320, 240, "png", "png", "png", "pictures/x.png"}};
    return out;
}

inline FlightResult flight_result(const std::string& controller, double within_deadline) {
    FlightResult out;
    out.controller = controller;
    out.summary = {2, 50.0, 40.0, 5.0, 7.5, within_deadline, 3, 1.5, 0.5, std::nullopt};
    out.frames = {{0.0, 10.0, 0, 1000, 0.0, 0.0, false, 1, std::nullopt},
                  {0.02, 25.0, 1, 250, 90.0, 2.0, true, 2, std::nullopt}};
    out.image_error_percent = 2.5;
    out.other_cores = 0.0;
    return out;
}

inline FrameRateResult frame_rate_result() {
    FrameRateResult out;
    out.asset = "terrain";
    out.motion = "there and back";
    out.target_fps = 50.0;
    out.screen = {640, 480};
    out.ladder = {{1000, 0.0}, {250, 2.0}, {60, 5.0}};
    for (const char* controller : {"none", "sblc", "isblc", "acceleration", "reactive", "predictive"}) {
        out.flights.push_back(flight_result(controller, 0.5));
        out.sweep.push_back({"nod", controller, 0.9, 0.8, 1.0, 2.0, 0.5});
        out.distributions.push_back({controller, {0.8, 0.9, 1.0}});
    }
    out.blur = {{1, 10.0, 3.0}, {4, 40.0, 1.0}};
    out.devices = 5;
    return out;
}

inline ReportData report_data() {
    ReportData data;
    data.provenance = {
        "lodestream-client report --out x", "0123abcd", "2024-01-01T00:00:00Z", "A CPU", 2, "A renderer", true, false};
    data.assets = {asset_result("teapot")};
    data.frame_rate = frame_rate_result();
    return data;
}

}  // namespace lodestream::report::testing
