#include "client/report/section_rows.h"

namespace lodestream::report {

Table overview_table(const ReportData& data) {
    return table_of<DeviceRow>(
        device_rows(data),
        {{"asset", "model", [](const auto& r) { return r.asset->asset.name; }},
         {"device", "device", [](const auto& r) { return r.device->device; }},
         {"capacity_mhz", "MHz", [](const auto& r) { return budget::capacity_mhz(r.device->request.device); }},
         {"dlr", "DLR", [](const auto& r) { return r.device->plan.dlr; }},
         {"ncp", "NCP", [](const auto& r) { return r.device->plan.ncp; }},
         {"budget_triangles", "budget", [](const auto& r) { return r.device->plan.budget.triangles; }},
         {"limited_by", "by", [](const auto& r) { return r.device->plan.budget.limited_by; }},
         {"triangles", "level", [](const auto& r) { return r.device->plan.level.triangles; }},
         {"gouraud", "Gouraud", [](const auto& r) { return r.device->plan.shading.gouraud; }},
         {"flat", "flat", [](const auto& r) { return r.device->plan.shading.flat; }},
         {"rms_error_percent", "RMS %", [](const auto& r) { return r.device->plan.level.rms_error_percent; }},
         {"screen_space_error_px", "max px", [](const auto& r) { return r.device->plan.level.screen_space_error_px; }},
         {"bytes", "bytes", [](const auto& r) { return r.device->plan.content.bytes; }},
         {"left_out_bytes", "left out", [](const auto& r) { return r.device->left_out_bytes; }},
         {"saved_percent", "vs G %", [](const auto& r) { return -saved_percent(*r.device); }},
         {"image_hybrid", "pic %", [](const auto& r) { return hybrid_of(*r.device).image.percent; }},
         {"image_gouraud", "all G %", [](const auto& r) { return gouraud_of(*r.device).image.percent; }},
         {"image_flat", "all F %", [](const auto& r) { return flat_of(*r.device).image.percent; }},
         {"plan_ms", "plan ms", [](const auto& r) { return r.device->plan.timing_ms.plan; }},
         {"cut_ms", "cut ms", [](const auto& r) { return r.device->plan.timing_ms.cut; }},
         {"encode_ms", "enc ms", [](const auto& r) { return r.device->plan.timing_ms.encode; }},
         {"fetch_ms", "fetch", [](const auto& r) { return hybrid_of(*r.device).fetch_ms; }},
         {"decode_ms", "decode", [](const auto& r) { return hybrid_of(*r.device).decode_ms; }},
         {"frame_ms", "frame ms", [](const auto& r) { return hybrid_of(*r.device).frame_ms; }}});
}

std::vector<Section> sections(const ReportData& data) {
    std::vector<Section> all{budget_section(data), simplification_section(data)};
    if (data.methods) all.push_back(methods_section(*data.methods));
    all.push_back(codec_section(data));
    if (data.codecs) all.push_back(codecs_section(*data.codecs));
    for (auto* section : {shading_section, end_to_end_section, hlod_section}) all.push_back(section(data));
    if (data.scenes) all.push_back(scenes_section(*data.scenes));
    all.push_back(points_section(data));
    if (data.points) {
        if (!data.points->scores.empty()) all.push_back(points_scores_section(*data.points));
        if (!data.points->settings.empty()) all.push_back(points_settings_section(*data.points));
        if (!data.points->crowds.empty()) all.push_back(points_crowds_section(*data.points));
        if (!data.points->choices.empty()) all.push_back(points_choices_section(*data.points));
    }
    all.push_back(frame_rate_section(data));
    return all;
}

}  // namespace lodestream::report
