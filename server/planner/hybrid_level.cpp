#include "server/planner/hybrid_level.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "common/shading/hybrid_split.h"
#include "common/shading/importance.h"

namespace lodestream::planner {

namespace {

// Regions of the split, from the closest to the order of gain to the cheapest border.
constexpr std::array<std::uint32_t, 3> region_counts{64, 16, 4};
constexpr std::uint32_t cheapest_regions = 1;

// What stays the same from one try to the next.
struct Job {
    const mesh::Model& model;
    const mesh::Mesh& level;
    const Forms& forms;
    const Extras& extras;
    std::uint64_t criterion_operations;
};

proto::ShadingMode mode_of(std::uint64_t gouraud, std::uint64_t flat) {
    if (flat == 0) return proto::ShadingMode::gouraud;
    return gouraud == 0 ? proto::ShadingMode::flat : proto::ShadingMode::hybrid;
}

Result<EncodedSplit> encode_with(const Job& job, const std::vector<std::uint8_t>& gouraud) {
    EncodedSplit result;
    result.gouraud = static_cast<std::uint64_t>(std::count(gouraud.begin(), gouraud.end(), std::uint8_t{1}));
    result.flat = gouraud.size() - result.gouraud;
    result.mode = mode_of(result.gouraud, result.flat);
    result.criterion_operations = job.criterion_operations;

    codec::EncodeOptions options = job.forms.plain;
    if (!job.forms.lean) options.extras_json = job.extras(result);
    Result<codec::Encoded> encoded = codec::encode_level(job.model, job.level, gouraud, options);
    if (!encoded) return encoded.error();
    if (job.forms.lean) {
        Result<codec::Encoded> lean = codec::encode_level(job.model, job.level, gouraud, *job.forms.lean);
        if (!lean) return lean.error();
        result.lean = lean->glb.size() <= encoded->glb.size();
        if (result.lean) encoded = std::move(lean);
    }
    result.encoded = std::move(*encoded);
    return result;
}

std::uint64_t wanted_gouraud(const SplitRequest& request, std::uint64_t triangles) {
    switch (request.mode) {
        case proto::ShadingMode::gouraud:
            return triangles;
        case proto::ShadingMode::flat:
            return 0;
        case proto::ShadingMode::hybrid:
            return shading::gouraud_count(triangles, request.distance);
    }
    return triangles;
}

}  // namespace

Result<EncodedSplit> encode_split(const mesh::Model& model, const mesh::Mesh& level, const SplitRequest& request,
                                  const Forms& forms, const FinerLevel& finer, const Extras& extras) {
    const std::size_t triangles = level.triangles.size();
    const std::uint64_t gouraud = wanted_gouraud(request, triangles);
    std::optional<shading::NormalErrors> errors;
    if (gouraud > 0 && gouraud < triangles) errors = shading::normal_errors(level, shading::ReferenceSurface(finer()));
    const shading::Importance importance = shading::importance(
        level, model.materials, {.view = request.view, .origin = model.origin, .errors = errors ? &*errors : nullptr});
    const Job job{model, level, forms, extras, importance.operations.criterion()};
    if (gouraud == 0) return encode_with(job, std::vector<std::uint8_t>(triangles, 0));

    Result<EncodedSplit> all_gouraud = encode_with(job, std::vector<std::uint8_t>(triangles, 1));
    if (!all_gouraud || gouraud == triangles) return all_gouraud;
    const std::uint64_t bytes_allowed = all_gouraud->encoded.glb.size();

    const std::vector<std::uint32_t> order = shading::order_by_gain(importance.gain);
    const auto encode_regions = [&](std::uint32_t regions) {
        return encode_with(job, shading::coherent_split(level, order, gouraud, regions));
    };
    const auto is_settled = [&](const Result<EncodedSplit>& hybrid) {
        return !hybrid || hybrid->encoded.glb.size() <= bytes_allowed;
    };
    // Plain levels code every border twice: where the cheapest is too dear, the others are.
    std::optional<Result<EncodedSplit>> cheapest;
    if (!forms.lean) {
        cheapest = encode_regions(cheapest_regions);
        if (!is_settled(*cheapest)) return all_gouraud;
    }
    for (const std::uint32_t regions : region_counts)
        if (Result<EncodedSplit> hybrid = encode_regions(regions); is_settled(hybrid)) return hybrid;
    if (!cheapest) cheapest = encode_regions(cheapest_regions);
    return is_settled(*cheapest) ? *std::move(cheapest) : all_gouraud;
}

}  // namespace lodestream::planner
