#include "client/report/section_rows.h"

#include <algorithm>

#include "client/report/text.h"

namespace lodestream::report {
namespace {

// A rung as stored, or a device's level in one shading mode.
struct CodecRow {
    std::string asset;
    Cell level, device;  // one of the two is empty
    proto::ShadingMode shading = proto::ShadingMode::gouraud;
    std::uint64_t triangles = 0, gouraud = 0, bytes = 0;
    double rms_error_percent = 0.0, decode_ms = 0.0;
};

proto::ShadingMode shading_of(std::uint64_t gouraud, std::uint64_t triangles) {
    if (gouraud == triangles) return proto::ShadingMode::gouraud;
    return gouraud == 0 ? proto::ShadingMode::flat : proto::ShadingMode::hybrid;
}

CodecRow rung_row(const AssetResult& asset, const LadderLevel& rung) {
    const proto::Level& level = rung.level;
    return {asset.asset.name, rung.index,   {},          shading_of(rung.gouraud, level.triangles),
            level.triangles,  rung.gouraud, level.bytes, level.rms_error_percent,
            rung.decode_ms};
}

CodecRow mode_row(const AssetResult& asset, const DeviceResult& device, const ModeResult& mode) {
    const auto& level = device.plan.level;
    return {asset.asset.name, {},         device.device,           mode.mode,     level.triangles,
            mode.gouraud,     mode.bytes, level.rms_error_percent, mode.decode_ms};
}

std::vector<CodecRow> codec_rows(const ReportData& data) {
    std::vector<CodecRow> rows;
    for (const AssetResult& asset : data.assets) {
        for (const LadderLevel& rung : asset.ladder) rows.push_back(rung_row(asset, rung));
        for (const DeviceResult& device : asset.devices)
            for (const ModeResult& mode : device.modes) rows.push_back(mode_row(asset, device, mode));
    }
    return rows;
}

Table mode_bytes_table(const ReportData& data) {
    return table_of<DeviceRow>(
        device_rows(data),
        {{"asset", "model", [](const auto& r) { return r.asset->asset.name; }},
         {"device", "device", [](const auto& r) { return r.device->device; }},
         {"triangles", "triangles", [](const auto& r) { return r.device->plan.level.triangles; }},
         {"flat", "of them flat", [](const auto& r) { return hybrid_of(*r.device).flat; }},
         {"hybrid", "hybrid, bytes", [](const auto& r) { return hybrid_of(*r.device).bytes; }},
         {"plain", "as plain glTF, bytes", [](const auto& r) { return r.device->plain_bytes; }},
         {"gouraud", "all Gouraud, bytes", [](const auto& r) { return gouraud_of(*r.device).bytes; }},
         {"flat_bytes", "all flat, bytes", [](const auto& r) { return flat_of(*r.device).bytes; }},
         {"saved", "hybrid saves %", [](const auto& r) { return saved_percent(*r.device); }},
         {"per_triangle", "hybrid, bytes a triangle",
          [](const auto& r) { return bytes_per_triangle(hybrid_of(*r.device).bytes, r.device->plan.level.triangles); }},
         {"decode", "decode ms", [](const auto& r) { return hybrid_of(*r.device).decode_ms; }},
         {"left_out_bytes", "left out, bytes", [](const auto& r) { return r.device->left_out_bytes; }}});
}

}  // namespace

Section codec_section(const ReportData& data) {
    Section section{"codec", "What a level costs to send", {}, {}, {}, {}, {}};
    section.text_html =
        "<p>A level travels as glTF 2.0 with Draco compression, in no more bits than its own error is worth: the rungs "
        "of the plots as plain glTF that any viewer shades in full, the devices’ levels lean, for our own clients, "
        "without normals that the triangles tell. The table compares the level that each device was sent with the "
        "same triangles all Gouraud shaded and all flat, and with what the same plan takes as plain glTF, where a "
        "hybrid level is often sent all Gouraud, as borders are coded twice; “left out” is what the server says it "
        "did not have to send.</p>";
    const auto bytes = [](const LadderLevel& rung) { return static_cast<double>(rung.level.bytes); };
    const auto triangles = [](const LadderLevel& rung) { return static_cast<double>(rung.level.triangles); };
    section.plots = {{"Error against bytes, level by level",
                      {"bytes", AxisScale::logarithmic},
                      {"RMS error, % of the model’s diagonal", AxisScale::logarithmic},
                      ladder_series(data, bytes, rms_percent),
                      {}},
                     {"Bytes a triangle",
                      {"triangles", AxisScale::logarithmic},
                      {"bytes a triangle"},
                      ladder_series(data, triangles,
                                    [](const AssetResult&, const LadderLevel& rung) {
                                        return bytes_per_triangle(rung.level.bytes, rung.level.triangles);
                                    }),
                      {}}};
    section.shown = mode_bytes_table(data);
    section.rows = table_of<CodecRow>(
        codec_rows(data),
        {{"asset", "", [](const auto& r) { return r.asset; }},
         {"level", "", [](const auto& r) { return r.level; }},
         {"device", "", [](const auto& r) { return r.device; }},
         {"shading", "", [](const auto& r) { return proto::shading_mode_name(r.shading); }},
         {"triangles", "", [](const auto& r) { return r.triangles; }},
         {"gouraud", "", [](const auto& r) { return r.gouraud; }},
         {"flat", "", [](const auto& r) { return r.triangles - std::min(r.gouraud, r.triangles); }},
         {"bytes", "", [](const auto& r) { return r.bytes; }},
         {"bytes_per_triangle", "", [](const auto& r) { return bytes_per_triangle(r.bytes, r.triangles); }},
         {"rms_error_percent", "", [](const auto& r) { return r.rms_error_percent; }},
         {"decode_ms", "", [](const auto& r) { return r.decode_ms; }}});
    return section;
}

}  // namespace lodestream::report
