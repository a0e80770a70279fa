#include "server/planner/planner.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cstdio>

#include "common/mesh/operations.h"
#include "common/simplify/history.h"
#include "proto/records.h"
#include "server/bake/bake.h"
#include "server/planner/baked_cache.h"
#include "server/planner/hybrid_level.h"

namespace lodestream::planner {

namespace {

// Times that a level over the network's bytes is cut again with the size it turned out to have.
constexpr int max_network_corrections = 3;
constexpr double network_margin = 1.01;

class Stopwatch {
  public:
    double ms() const {
        return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start_).count();
    }

  private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

budget::AssetCost cost_of(const proto::Asset& asset) {
    budget::AssetCost cost;
    cost.triangles = asset.triangles;
    for (const proto::Level& level : asset.levels) cost.sizes.push_back({level.triangles, level.bytes});
    return cost;
}

Error not_ready(const proto::Asset& asset) {
    if (asset.status == proto::AssetStatus::baking)
        return fail(ErrorCode::unavailable, "asset '" + asset.name + "' is still baking; ask again soon");
    return fail(ErrorCode::conflict, "asset '" + asset.name + "' failed to bake: " + asset.error);
}

// Names everything that the encoded bytes depend on. The view matters only where triangles are chosen by it.
std::string content_key(std::uint64_t triangles, const SplitRequest& split, const Vec3d& center) {
    std::string key = "level/importance/" + std::to_string(triangles) + "/" + proto::shading_mode_name(split.mode);
    if (split.mode != proto::ShadingMode::hybrid || split.distance <= 0.0 || split.distance >= 1.0) {
        return key + (split.mode == proto::ShadingMode::hybrid ? (split.distance <= 0.0 ? "/near" : "/far") : "");
    }
    const Vec3d eye = split.view.eye - center, light = split.view.light;
    for (const double number : {split.distance, eye.x, eye.y, eye.z, light.x, light.y, light.z}) {
        char hex[24];
        std::snprintf(hex, sizeof hex, "/%016llx",
                      static_cast<unsigned long long>(std::bit_cast<std::uint64_t>(number)));
        key += hex;
    }
    return key;
}

void fill_shading(proto::PlanResponse& response, const EncodedSplit& split) {
    response.shading.gouraud = split.gouraud;
    response.shading.flat = split.flat;
    response.shading.operations = budget::with_shading(split.criterion_operations, split.gouraud, split.flat);
    response.shading.mode = proto::shading_mode_name(split.mode);
}

void fill_content(proto::PlanResponse& response, const codec::Encoded& encoded, std::uint64_t full_bytes) {
    response.level.vertices = encoded.vertices;
    response.content.bytes = encoded.glb.size();
    if (full_bytes > response.content.bytes)
        response.left_out.push_back({"triangles beyond the budget", full_bytes - response.content.bytes});
    for (const auto& [what, bytes] : encoded.left_out) response.left_out.push_back({what, bytes});
}

}  // namespace

struct Planner::Impl {
    explicit Impl(store::Store& s) : store(s), cache(s) {}

    store::Store& store;
    BakedCache cache;

    Result<proto::PlanResponse> plan(const proto::PlanRequest& request);
    Result<proto::PlanResponse> plan_level(const proto::PlanRequest& request, const proto::Asset& asset,
                                           LoadedAsset& loaded, const budget::Budget& budget);
    Status add_content(proto::PlanResponse& response, const proto::Asset& asset, LoadedAsset& loaded,
                       const SplitRequest& split, std::uint64_t triangles);
};

// Cuts, measures, splits, encodes and stores one level, unless the store has it.
Status Planner::Impl::add_content(proto::PlanResponse& response, const proto::Asset& asset, LoadedAsset& loaded,
                                  const SplitRequest& split, std::uint64_t triangles) {
    const std::string key = content_key(triangles, split, loaded.world_bounds.center());
    if (Result<store::Store::Content> stored = store.content(asset.id, key)) {
        Result<proto::PlanResponse> record = proto::parse_plan_response(stored->record);
        if (!record) return record.error();
        response.level = record->level;
        response.shading = record->shading;
        response.content = record->content;
        response.content.url = bake::content_url(stored->file.hash);
        response.left_out = record->left_out;
        response.warnings = record->warnings;
        return Nothing{};
    }

    const Stopwatch cutting;
    const mesh::Model& model = loaded.baked.model;
    const mesh::Mesh level = simplify::cut(model.mesh, loaded.baked.history, triangles);
    response.timing_ms.cut = cutting.ms();
    const metric::SurfaceError error = loaded.error_of(level, response.timing_ms.measure);
    response.level.rms_error = error.rms;
    response.level.max_error = error.max;
    response.level.rms_error_percent = bake::percent_of_diagonal(error.rms, loaded.bounds);

    const Stopwatch encoding;
    codec::EncodeOptions options;
    options.grid = bake::level_grid(model.mesh, level, error);
    response.level.triangles = level.triangles.size();
    const Extras extras = [&](const EncodedSplit& attempt) {
        proto::PlanResponse figures = response;
        fill_shading(figures, attempt);
        return proto::content_extras(asset.id, figures);
    };
    Result<EncodedSplit> encoded = encode_split(model, level, split, options, extras);
    if (!encoded) return encoded.error();
    response.timing_ms.encode = encoding.ms();

    const std::uint64_t full_bytes = asset.levels.empty() ? 0 : asset.levels.front().bytes;
    fill_shading(response, *encoded);
    fill_content(response, encoded->encoded, full_bytes);
    if (split.mode == proto::ShadingMode::hybrid && encoded->mode == proto::ShadingMode::gouraud &&
        split.distance > 0.0)
        response.warnings.push_back("sent all Gouraud: every split of this level would have been larger");

    Result<store::StoredFile> file =
        store.put_content(asset.id, key, "glb", encoded->encoded.glb, proto::to_json(response));
    if (!file) return file.error();
    response.content.url = bake::content_url(file->hash);
    return Nothing{};
}

Result<proto::PlanResponse> Planner::Impl::plan_level(const proto::PlanRequest& request, const proto::Asset& asset,
                                                      LoadedAsset& loaded, const budget::Budget& budget) {
    proto::PlanResponse response;
    response.dlr = budget.dlr;
    response.ncp = budget.ncp;
    response.rup = budget.rup;
    response.budget = {budget.triangles, budget::limited_by_name(budget.limited_by), budget.feasible};

    SplitRequest split;
    split.mode = request.shading;
    split.view = request.view ? *request.view : shading::framing_view(loaded.world_bounds);
    const budget::Display display = request.budget.display.value_or(shading::default_display);
    split.distance =
        shading::distance_level(split.view, loaded.world_bounds, display, shading::distance_steps(budget.dlr));

    if (Status added = add_content(response, asset, loaded, split, budget.triangles); !added) return added.error();
    response.shading.distance = split.distance;
    response.level.screen_space_error_px =
        response.level.max_error * shading::pixels_per_unit(split.view, loaded.world_bounds, display);
    if (!budget.feasible)
        response.warnings.push_back(std::string("the ") + budget::limited_by_name(budget.limited_by) +
                                    " allows less than one triangle; the least there is was sent");
    return response;
}

Result<proto::PlanResponse> Planner::Impl::plan(const proto::PlanRequest& request) {
    const Stopwatch watch;
    if (request.profile != proto::Profile::plain)
        return fail(ErrorCode::unsupported, "profile 'lean' is not offered by this server; ask for 'plain'");
    if (request.view)
        if (Status valid = shading::validate(*request.view); !valid) return valid.error();
    Result<proto::Asset> asset = store.asset(request.asset);
    if (!asset) return asset.error();
    if (asset->status != proto::AssetStatus::ready) return not_ready(*asset);
    Result<std::shared_ptr<LoadedAsset>> loaded = cache.load(asset->id);
    if (!loaded) return loaded.error();

    budget::AssetCost cost = cost_of(*asset);
    for (int correction = 0;; ++correction) {
        Result<budget::Budget> budget = budget::derive_budget(request.budget, cost);
        if (!budget) return budget.error();
        Result<proto::PlanResponse> response = plan_level(request, *asset, **loaded, *budget);
        if (!response) return response;
        const double excess = budget::network_excess(request.budget, response->content.bytes);
        if (budget->limited_by == budget::LimitedBy::network && excess > 1.0 && budget->triangles > 1 &&
            correction < max_network_corrections) {
            cost.bytes_factor *= excess * network_margin;
            continue;
        }
        response->timing_ms.plan = watch.ms();
        return response;
    }
}

Planner::Planner(store::Store& store) : impl_(std::make_unique<Impl>(store)) {}
Planner::~Planner() = default;

Result<proto::PlanResponse> Planner::plan(const proto::PlanRequest& request) {
    return impl_->plan(request);
}

Result<Planner::Cut> Planner::cut(std::string_view name, std::uint64_t triangles) {
    if (triangles == 0) return invalid_input("a cut has at least one triangle");
    Result<proto::Asset> asset = impl_->store.asset(name);
    if (!asset) return asset.error();
    if (asset->status != proto::AssetStatus::ready) return not_ready(*asset);
    Result<std::shared_ptr<LoadedAsset>> loaded = impl_->cache.load(asset->id);
    if (!loaded) return loaded.error();

    const mesh::Model& model = (*loaded)->baked.model;
    Cut result;
    const Stopwatch watch;
    result.model.mesh = simplify::cut(model.mesh, (*loaded)->baked.history, triangles);
    result.cut_ms = watch.ms();
    result.model.materials = model.materials;
    result.model.images = model.images;
    result.model.origin = model.origin;
    result.model.kind = model.kind;
    result.model.objects = model.objects;
    result.error = (*loaded)->error_of(result.model.mesh, result.measure_ms);
    result.rms_error_percent = bake::percent_of_diagonal(result.error.rms, (*loaded)->bounds);
    return result;
}

void Planner::forget(std::string_view asset_id) {
    impl_->cache.forget(std::string(asset_id));
}

}  // namespace lodestream::planner
