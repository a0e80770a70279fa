#include "client/probe/probe.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "client/probe/cpu.h"
#include "client/render/gl_context.h"
#include "proto/messages.h"

namespace lodestream::probe {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

Report constructed() {
    Report report;
    report.machine.name = "A \"CPU\"";
    report.machine.cpu_mhz = 2000.0;
    report.machine.cpu_cores = 2;
    report.machine.memory_mb = 4096.0;
    report.graphics = {{3e6, 1.5, 9}, {2e6, 2.5, 9}, {5e6, 1.0, 9}, {1e8, 0.5, 9}, {}, 90, 80};
    report.graphics.costs.fixed_ms = 0.25;
    report.cpu_single = {5e8, 1.0, 15};
    report.cpu_all = {9e8, 1.0, 15};
    report.renderer = "llvmpipe";
    report.software_renderer = true;
    report.other_cores = 0.02;
    report.seconds = 2.5;
    return report;
}

// A square of side 2 with waves of 0.1.
mesh::Model constructed_waves(std::uint32_t side) {
    mesh::Model model;
    model.materials.emplace_back();
    for (std::uint32_t i = 0; i <= side; ++i)
        for (std::uint32_t j = 0; j <= side; ++j) {
            const float x = 2.0f * static_cast<float>(j) / static_cast<float>(side) - 1.0f;
            const float z = 2.0f * static_cast<float>(i) / static_cast<float>(side) - 1.0f;
            model.mesh.positions.push_back({x, 0.1f * std::sin(9.0f * x) * std::cos(9.0f * z), z});
            model.mesh.normals.push_back({0, 1, 0});
        }
    for (std::uint32_t i = 0; i < side; ++i)
        for (std::uint32_t j = 0; j < side; ++j) {
            const std::uint32_t a = i * (side + 1) + j, b = a + side + 1;
            model.mesh.triangles.push_back({a, b, b + 1});
            model.mesh.triangles.push_back({a, b + 1, a + 1});
        }
    return model;
}

TEST(Probe, ItsJsonIsADeviceFile) {
    const auto request = proto::parse_device_file(to_json(constructed()));
    ASSERT_TRUE(request) << request.error().message;
    EXPECT_EQ(request->budget.device.name, "A \"CPU\"");
    EXPECT_EQ(request->budget.device.cpu_mhz, 2000.0);
    EXPECT_EQ(request->budget.device.cpu_cores, 2u);
    EXPECT_EQ(request->budget.device.gpu, budget::Gpu::none);
    EXPECT_EQ(*request->budget.device.memory_mb, 4096.0);
    EXPECT_EQ(*request->budget.device.triangles_per_second, 2e6);  // the lower rate
    EXPECT_EQ(*request->budget.device.points_per_second, 5e6);
    EXPECT_EQ(*request->budget.device.flat_triangles_per_second, constructed().graphics.flat_triangles.per_second);
    EXPECT_FALSE(request->budget.display);
}

TEST(Probe, ADeviceWhoseClockIsNotKnownCanBePlannedFor) {
    Report report = constructed();
    report.machine.cpu_mhz.reset();
    report.machine.display = budget::Display{1920, 1080};
    const auto request = proto::parse_device_file(to_json(report));
    ASSERT_TRUE(request) << request.error().message;
    EXPECT_EQ(request->budget.display->width, 1920u);
    EXPECT_TRUE(budget::validate(request->budget));
}

TEST(Probe, TellsWhatAFrameCosts) {
    EXPECT_THAT(to_json(constructed()), HasSubstr("\"frame_costs\":{\"fixed_ms\":0.25,"));
    EXPECT_THAT(to_text(constructed()), HasSubstr("0.250 ms"));
}

TEST(Probe, SaysWhenItWasDisturbed) {
    Report report = constructed();
    EXPECT_FALSE(disturbed(report));
    EXPECT_THAT(to_text(report), Not(HasSubstr("DISTURBED")));
    EXPECT_THAT(to_json(report), HasSubstr("\"disturbed\":false"));
    report.other_cores = 0.9;
    EXPECT_THAT(to_text(report), HasSubstr("DISTURBED"));
    EXPECT_THAT(to_json(report), HasSubstr("\"disturbed\":true"));
    report.other_cores.reset();
    EXPECT_FALSE(disturbed(report));
    EXPECT_THAT(to_json(report), HasSubstr("\"other_cores\":null"));
}

TEST(Probe, CpuRatesArePositiveAndComeFromSeveralRuns) {
    const Rate one = measure_cpu(1, 0.2);
    EXPECT_GT(one.per_second, 1e5);
    EXPECT_GE(one.runs, 2u);
}

// Within a factor of five, whatever else a machine that runs tests does meanwhile: a wrong unit is more.
TEST(Probe, ItsCostsPredictThisDevicesFrames) {
    const auto context = render::create_headless_context();
    ASSERT_TRUE(context) << context.error().message;
    auto renderer = render::Renderer::create();
    ASSERT_TRUE(renderer) << renderer.error().message;
    const auto graphics = measure_graphics(*renderer);
    ASSERT_TRUE(graphics) << graphics.error().message;
    const shading::View view{{0.3, 0.9, 1.8}, {0, 0, 0}, 45.0, {0.3, 1.0, 0.5}};
    for (const std::uint32_t side : {12u, 120u}) {
        const mesh::Model waves = constructed_waves(side);
        for (const bool flat : {false, true}) {
            const std::vector<std::uint8_t> gouraud(waves.mesh.triangles.size(), flat ? 0 : 1);
            const codec::Decoded content = render::drawable(waves, waves.mesh, gouraud);
            ASSERT_TRUE(renderer->upload(content));
            for (const budget::Display display : {budget::Display{320, 240}, budget::Display{1280, 1024}}) {
                render::DrawOptions options;
                options.width = display.width;
                options.height = display.height;
                options.samples = 1;
                std::vector<TimedRun> runs;
                for (int i = 0; i < 20; ++i) runs.push_back({renderer->draw(view, options)->frame_ms, 0.0});
                const double predicted_ms = control::frame_ms(graphics->costs, work_of(content, view, display));
                EXPECT_GT(predicted_ms / timing_of(runs).ms, 1.0 / 5.0) << side << " " << flat << " " << display.width;
                EXPECT_LT(predicted_ms / timing_of(runs).ms, 5.0) << side << " " << flat << " " << display.width;
            }
        }
    }
}

TEST(Probe, MeasuresThisDevice) {
    const auto report = measure();
    ASSERT_TRUE(report) << report.error().message;
    for (const Rate& rate : {report->graphics.gouraud_triangles, report->graphics.flat_triangles,
                             report->graphics.points, report->graphics.pixels, report->cpu_single, report->cpu_all}) {
        EXPECT_GT(rate.per_second, 0.0);
        EXPECT_GE(rate.runs, 1u);
        EXPECT_LE(rate.uncertainty_percent, 100.0);
    }
    EXPECT_GE(report->graphics.runs, report->graphics.calm_runs);
    // Which of them pays for a triangle is the fit's choice: itself, its vertices or its length on the screen.
    const control::FrameCosts& costs = report->graphics.costs;
    const control::Work nothing{}, million{.triangles = 1e6, .vertices = 5e5, .extent_px = 1e6};
    EXPECT_GT(control::frame_ms(costs, million), control::frame_ms(costs, nothing));
    EXPECT_TRUE(proto::parse_device_file(to_json(*report)));
}

}  // namespace
}  // namespace lodestream::probe
