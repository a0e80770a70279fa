#include "client/probe/probe.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "client/probe/cpu.h"
#include "client/probe/load_meter.h"
#include "client/render/gl_context.h"

namespace lodestream::probe {

namespace {

// With usual_seconds of graphics they leave 1.3 s to open the driver, to make balls and to upload them.
constexpr double cpu_s = 0.2;
// What probes, each a process of its own on a quiet machine, differ by from their median in 19 of 20 cases although the
// runs of each agree: memory lies elsewhere (tests/bench, probe).
constexpr double graphics_between_probes_percent = 8.0, cpu_between_probes_percent = 4.5;

std::string quoted(const std::string& text) {
    std::string out = "\"";
    for (const char c : text) {
        if (static_cast<unsigned char>(c) < 0x20) continue;
        if (c == '"' || c == '\\') out += '\\';
        out += c;
    }
    return out + '"';
}

std::string number(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.6g", std::isfinite(value) ? value : 0.0);
    return text;
}

std::string rate_json(const char* name, const Rate& rate) {
    std::string out = quoted(name);
    out += ":" + number(rate.per_second) + ",";
    out += quoted(std::string(name) + "_uncertainty_percent");
    out += ":" + number(rate.uncertainty_percent) + ",";
    return out;
}

std::string costs_json(const control::FrameCosts& costs) {
    return "\"frame_costs\":{\"fixed_ms\":" + number(costs.fixed_ms) +
           ",\"per_million_triangles_ms\":" + number(costs.per_million_triangles_ms) +
           ",\"per_million_vertices_ms\":" + number(costs.per_million_vertices_ms) +
           ",\"per_million_pixels_ms\":" + number(costs.per_million_pixels_ms) +
           ",\"per_million_shaded_ms\":" + number(costs.per_million_shaded_ms) +
           ",\"per_million_textured_ms\":" + number(costs.per_million_textured_ms) +
           ",\"per_million_extent_ms\":" + number(costs.per_million_extent_ms) + "},";
}

std::string rate_text(const char* name, const Rate& rate, const char* unit) {
    char text[128];
    std::snprintf(text, sizeof text, "%-22s %10.3f million %s/s  ± %.1f %% (%zu runs)\n", name, rate.per_second * 1e-6,
                  unit, rate.uncertainty_percent, rate.runs);
    return text;
}

std::string costs_text(const control::FrameCosts& costs) {
    char text[256];
    std::snprintf(text, sizeof text,
                  "a frame                %.3f ms, and a million triangles %.1f, vertices %.1f, px of the picture "
                  "%.2f, px shaded %.2f, textured %.2f more, px of triangles' sides %.1f\n",
                  costs.fixed_ms, costs.per_million_triangles_ms, costs.per_million_vertices_ms,
                  costs.per_million_pixels_ms, costs.per_million_shaded_ms, costs.per_million_textured_ms,
                  costs.per_million_extent_ms);
    return text;
}

std::string load_text(const Report& report) {
    if (!report.other_cores) return "other load             not known\n";
    char text[160];
    std::snprintf(text, sizeof text, "other load             %.2f of %u cores%s\n", *report.other_cores,
                  report.machine.cpu_cores,
                  disturbed(report) ? "  DISTURBED: another process was busy; this device may be faster" : "");
    return text;
}

}  // namespace

Result<Report> measure() {
    const auto start = std::chrono::steady_clock::now();
    const LoadMeter load;
    Report report;
    report.machine = read_machine();
    report.cpu_single = widened(measure_cpu(1, cpu_s), cpu_between_probes_percent);
    report.cpu_all = widened(measure_cpu(report.machine.cpu_cores, cpu_s), cpu_between_probes_percent);
    const auto context = render::create_headless_context();
    if (!context) return context.error();
    auto renderer = render::Renderer::create();
    if (!renderer) return renderer.error();
    const auto graphics = measure_graphics(*renderer);
    if (!graphics) return graphics.error();
    report.graphics = *graphics;
    for (Rate* rate : {&report.graphics.gouraud_triangles, &report.graphics.flat_triangles, &report.graphics.points,
                       &report.graphics.pixels})
        *rate = widened(*rate, graphics_between_probes_percent);
    report.renderer = context->renderer();
    report.software_renderer = context->software();
    report.other_cores = load.other_cores();
    report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return report;
}

bool disturbed(const Report& report) {
    return report.other_cores && *report.other_cores > disturbed_above_cores;
}

budget::DeviceReport device_report(const Report& report) {
    budget::DeviceReport device;
    device.name = report.machine.name;
    device.cpu_mhz = report.machine.cpu_mhz.value_or(0.0);
    device.cpu_cores = report.machine.cpu_cores;
    device.gpu = report.software_renderer ? budget::Gpu::none : budget::Gpu::discrete;
    device.memory_mb = report.machine.memory_mb;
    device.triangles_per_second =
        std::min(report.graphics.gouraud_triangles.per_second, report.graphics.flat_triangles.per_second);
    device.points_per_second = report.graphics.points.per_second;
    device.flat_triangles_per_second = report.graphics.flat_triangles.per_second;
    return device;
}

std::string to_json(const Report& report) {
    const budget::DeviceReport device = device_report(report);
    std::string out = "{\"device\":{\"name\":" + quoted(device.name) + ",\"cpu_mhz\":" + number(device.cpu_mhz) +
                      ",\"cpu_cores\":" + std::to_string(device.cpu_cores) +
                      ",\"gpu\":" + (device.gpu == budget::Gpu::discrete ? "\"discrete\"" : "\"none\"");
    if (device.memory_mb) out += ",\"memory_mb\":" + number(*device.memory_mb);
    out += ",\"triangles_per_second\":" + number(*device.triangles_per_second) +
           ",\"points_per_second\":" + number(*device.points_per_second) +
           ",\"flat_triangles_per_second\":" + number(*device.flat_triangles_per_second) + "},";
    if (const auto& display = report.machine.display)
        out += "\"display\":{\"width\":" + std::to_string(display->width) +
               ",\"height\":" + std::to_string(display->height) + "},";
    out += "\"measured\":{" + rate_json("gouraud_triangles_per_second", report.graphics.gouraud_triangles) +
           rate_json("flat_triangles_per_second", report.graphics.flat_triangles) +
           rate_json("points_per_second", report.graphics.points) +
           rate_json("pixels_per_second", report.graphics.pixels) +
           rate_json("cpu_single_operations_per_second", report.cpu_single) +
           rate_json("cpu_all_operations_per_second", report.cpu_all);
    out += costs_json(report.graphics.costs) + "\"renderer\":" + quoted(report.renderer) +
           ",\"other_cores\":" + (report.other_cores ? number(*report.other_cores) : "null") +
           ",\"calm_runs\":" + std::to_string(report.graphics.calm_runs) +
           ",\"runs\":" + std::to_string(report.graphics.runs) +
           ",\"disturbed\":" + (disturbed(report) ? "true" : "false") + ",\"seconds\":" + number(report.seconds) + "}}";
    return out;
}

std::string to_text(const Report& report) {
    const Machine& machine = report.machine;
    std::string out = "processor              " + (machine.name.empty() ? "not known" : machine.name) + ", " +
                      std::to_string(machine.cpu_cores) + " cores" +
                      (machine.cpu_mhz ? ", " + number(std::round(*machine.cpu_mhz)) + " MHz" : "") + "\n";
    out += "renderer               " + report.renderer + "\n";
    if (machine.memory_mb) out += "memory                 " + number(std::round(*machine.memory_mb)) + " MB\n";
    if (machine.display)
        out += "display                " + std::to_string(machine.display->width) + "x" +
               std::to_string(machine.display->height) + " px\n";
    out += rate_text("Gouraud", report.graphics.gouraud_triangles, "triangles") +
           rate_text("flat", report.graphics.flat_triangles, "triangles") +
           rate_text("points", report.graphics.points, "points") + rate_text("fill", report.graphics.pixels, "pixels") +
           rate_text("processor, one core", report.cpu_single, "operations") +
           rate_text("processor, all cores", report.cpu_all, "operations");
    return out + costs_text(report.graphics.costs) + load_text(report) + "measured in            " +
           number(std::round(report.seconds * 100.0) / 100.0) + " s\n";
}

}  // namespace lodestream::probe
