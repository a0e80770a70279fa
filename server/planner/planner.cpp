#include "server/planner/planner.h"

#include <algorithm>
#include <bit>
#include <cstdio>

#include "common/mesh/operations.h"
#include "common/simplify/history.h"
#include "proto/records.h"
#include "server/bake/bake.h"
#include "server/bake/stopwatch.h"
#include "server/bake/textures.h"
#include "server/planner/baked_cache.h"
#include "server/planner/hybrid_level.h"
#include "server/planner/point_level.h"

namespace lodestream::planner {

namespace {

// Of the level that a hybrid split is chosen against. Four times finer, its normals are half as far off.
constexpr std::uint64_t reference_triangles_per_triangle = 4;
// Times that a level over the network's bytes is cut again with the size it turned out to have.
constexpr int max_network_corrections = 3;
constexpr double network_margin = 1.01;

using bake::Stopwatch;

// Without the images, which are chosen apart.
std::uint64_t geometry_bytes(const proto::Level& level) {
    return level.bytes - std::min(level.bytes, level.texture_bytes);
}

budget::AssetCost cost_of(const proto::Asset& asset, const texture::Choice& textures) {
    budget::AssetCost cost;
    cost.triangles = asset.levels.empty() ? asset.triangles : asset.levels.front().triangles;
    cost.fixed_bytes = textures.bytes;
    for (const proto::Level& level : asset.levels) cost.sizes.push_back({level.triangles, geometry_bytes(level)});
    return cost;
}

shading::View view_of(const proto::PlanRequest& request, const Box& world_bounds) {
    return request.view ? *request.view : shading::framing_view(world_bounds);
}

budget::Display display_of(const proto::PlanRequest& request) {
    return request.budget.display.value_or(shading::default_display);
}

// What the request can see and carry of the asset's images. Of the network they get their share, or all that the whole
// geometry leaves.
texture::Needs texture_needs(const proto::PlanRequest& request, const proto::Asset& asset, const LoadedAsset& loaded) {
    texture::Needs needs;
    if (request.budget.display) {
        const double pixels_per_unit = shading::pixels_per_unit(view_of(request, loaded.world_bounds),
                                                                loaded.world_bounds, *request.budget.display);
        if (pixels_per_unit > 0.0) needs.pixel_size = 1.0 / pixels_per_unit;
    }
    const double network = budget::network_bytes(request.budget);
    const double geometry = asset.levels.empty() ? 0.0 : static_cast<double>(geometry_bytes(asset.levels.front()));
    needs.max_bytes = std::max(texture::network_share * network, network - geometry);
    return needs;
}

Error not_ready(const proto::Asset& asset) {
    if (asset.status == proto::AssetStatus::baking)
        return fail(ErrorCode::unavailable, "asset '" + asset.name + "' is still baking; ask again soon");
    return fail(ErrorCode::conflict, "asset '" + asset.name + "' failed to bake: " + asset.error);
}

Error no_triangles(const proto::Asset& asset) {
    return fail(ErrorCode::conflict, "asset '" + asset.name +
                                         "' is a cloud of points and has no triangles; ask for \"primitives\": "
                                         "\"points\" or \"any\"");
}

Box world_bounds_of(const proto::Asset& asset) {
    Box box;
    for (const auto& corner : {asset.bounds_min, asset.bounds_max})
        if (corner) box.add({(*corner)[0], (*corner)[1], (*corner)[2]});
    return box;
}

void fill_budget(proto::PlanResponse& response, const budget::Budget& budget) {
    response.dlr = budget.dlr;
    response.ncp = budget.ncp;
    response.rup = budget.rup;
    response.budget = {budget.triangles, budget::limited_by_name(budget.limited_by), budget.feasible, {}};
    if (!budget.feasible)
        response.warnings.push_back(std::string("the ") + budget::limited_by_name(budget.limited_by) +
                                    " allows less than one triangle; the least there is was sent");
}

// Where the object is in the view, which the distance d and the error in pixels follow from.
struct Placement {
    shading::View view;
    budget::Display display;
    double distance = 0.0;
};

Placement place(const proto::PlanRequest& request, const Box& world_bounds, double dlr) {
    Placement placement{view_of(request, world_bounds), display_of(request)};
    placement.distance =
        shading::distance_level(placement.view, world_bounds, placement.display, shading::distance_steps(dlr));
    return placement;
}

// The finest first level that the budget and the network allow; the coarsest where the network allows none; null where
// the budget does not.
const proto::Level* find_first_level(const proto::Asset& asset, std::uint64_t triangles, double network_bytes) {
    const proto::Level* found = nullptr;
    for (const proto::Level& level : asset.levels) {
        if (level.triangles > triangles) continue;
        found = &level;
        if (static_cast<double>(level.bytes) <= network_bytes) break;
    }
    return found;
}

void fill_first_level(proto::PlanResponse& response, const proto::Level& level, const proto::PlanRequest& request) {
    response.level.triangles = level.triangles;
    response.level.vertices = level.vertices;
    response.level.rms_error = level.rms_error;
    response.level.max_error = level.max_error;
    response.level.normal_error_degrees = level.normal_error_degrees;
    response.level.rms_error_percent = level.rms_error_percent;
    response.shading.gouraud = level.triangles;
    response.shading.operations = budget::with_shading(0, level.triangles, 0);
    response.shading.mode = proto::shading_mode_name(proto::ShadingMode::gouraud);
    response.content.url = level.url;
    response.content.bytes = level.bytes;
    response.warnings.push_back("a first level, made before the bake is done; ask again for a better one");
    if (request.shading == proto::ShadingMode::flat)
        response.warnings.push_back("first levels are all Gouraud: flat shading comes with the bake");
}

struct LevelRequest {
    std::uint64_t triangles = 0;
    const bake::ShellView* shell = nullptr;  // to cut it from; null: from the whole asset
    SplitRequest split;
    const texture::Choice& textures;
    proto::Profile profile = proto::Profile::plain;
};

bool is_inside(const Vec3d& eye, const Box& box) {
    return glm::all(glm::greaterThanEqual(eye, box.min)) && glm::all(glm::lessThanEqual(eye, box.max));
}

// What the level is off from what its viewer can see of the asset.
metric::SurfaceError seen_error(const proto::PlanResponse& response) {
    const auto& level = response.level;
    if (level.outside) return {level.outside->rms_error, level.outside->max_error, level.normal_error_degrees};
    return {level.rms_error, level.max_error, level.normal_error_degrees};
}

// Names everything that the encoded bytes depend on, the order of triangles by its first word and the form of lean
// levels by theirs: what an older server stored is made anew. The view matters only where triangles are chosen by it.
std::string content_key(const LevelRequest& level, const Vec3d& center) {
    const SplitRequest& split = level.split;
    std::string key = "level/gain-2/" + std::to_string(level.triangles) + "/" + proto::shading_mode_name(split.mode);
    if (level.shell) key += "/outside";
    if (level.profile == proto::Profile::lean) key += "/lean-mesh-2";
    if (!level.textures.key.empty()) key += "/images" + level.textures.key;
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

void fill_content(proto::PlanResponse& response, const codec::Encoded& encoded, std::uint64_t full_geometry_bytes) {
    response.level.vertices = encoded.vertices;
    response.content.bytes = encoded.glb.size();
    const std::uint64_t own_bytes = encoded.glb.size() - encoded.texture_bytes;
    if (full_geometry_bytes > own_bytes)
        response.left_out.push_back({"triangles beyond the budget", full_geometry_bytes - own_bytes});
    for (const auto& [what, bytes] : encoded.left_out) response.left_out.push_back({what, bytes});
}

}  // namespace

struct Planner::Impl {
    explicit Impl(store::Store& s) : store(s), cache(s) {}

    store::Store& store;
    BakedCache cache;

    Result<proto::PlanResponse> plan(const proto::PlanRequest& request);
    Result<proto::PlanResponse> plan_baked(const proto::PlanRequest& request, const proto::Asset& asset);
    Result<proto::PlanResponse> plan_triangles(const proto::PlanRequest& request, const proto::Asset& asset,
                                               const LoadedAsset& loaded);
    Result<proto::PlanResponse> plan_points(const proto::PlanRequest& request, const proto::Asset& asset,
                                            const Box& world_bounds);
    Status choose_primitives(proto::PlanResponse& response, const proto::PlanRequest& request,
                             const proto::Asset& asset, const LoadedAsset& loaded);
    Result<proto::PlanResponse> plan_level(const proto::PlanRequest& request, const proto::Asset& asset,
                                           const LoadedAsset& loaded, const texture::Choice& textures,
                                           const budget::Budget& budget);
    Status add_content(proto::PlanResponse& response, const proto::Asset& asset, const LoadedAsset& loaded,
                       const LevelRequest& wanted);
};

// Cuts, measures, splits, encodes and stores one level, unless the store has it.
Status Planner::Impl::add_content(proto::PlanResponse& response, const proto::Asset& asset, const LoadedAsset& loaded,
                                  const LevelRequest& wanted) {
    const SplitRequest& split = wanted.split;
    const std::string key = content_key(wanted, loaded.world_bounds.center());
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
    const bake::ShellView* shell = wanted.shell;
    const bake::BakedView& baked = shell ? shell->baked : loaded.baked;
    const auto cut = [&](std::uint64_t triangles) {
        return shell ? bake::cut_shell(*shell, triangles) : simplify::cut(baked.history, triangles);
    };
    mesh::Mesh level = cut(wanted.triangles);
    const metric::SurfaceError error = bake::error_of(baked.errors, level.triangles.size());
    response.level.triangles = level.triangles.size();
    response.level.rms_error = error.rms;
    response.level.max_error = error.max;
    response.level.normal_error_degrees = error.normal_degrees;
    response.level.rms_error_percent = bake::percent_of_diagonal(error.rms, baked.bounds);
    if (shell) {
        const metric::SurfaceError seen = bake::error_of(shell->seen_errors, level.triangles.size());
        response.level.outside = {seen.rms, seen.max};
    }
    std::optional<mesh::Model> painted;
    if (shell && !shell->colored_by.empty()) {
        Result<mesh::Model> own = loaded.colors->paint(level);
        if (!own) return own.error();
        painted = *std::move(own);
        painted->origin = baked.model.origin;
        level = std::move(painted->mesh);
    }
    response.timing_ms.cut = cutting.ms();

    const Stopwatch encoding;
    const auto form = [&](bool lean) {
        codec::EncodeOptions options = bake::level_options(baked.grid_bounds, level, seen_error(response), lean);
        if (!painted) options.images = wanted.textures.images;
        return options;
    };
    Forms forms{form(false), std::nullopt};
    if (wanted.profile == proto::Profile::lean) forms.lean = form(true);
    const Extras extras = [&](const EncodedSplit& attempt) {
        proto::PlanResponse figures = response;
        fill_shading(figures, attempt);
        return proto::content_extras(asset.id, figures);
    };
    const FinerLevel finer = [&] { return cut(reference_triangles_per_triangle * level.triangles.size()); };
    Result<EncodedSplit> encoded = encode_split(painted ? *painted : baked.model, level, split, forms, finer, extras);
    if (!encoded) return encoded.error();
    response.timing_ms.encode = encoding.ms();

    fill_shading(response, *encoded);
    response.content.profile = proto::profile_name(encoded->lean ? proto::Profile::lean : proto::Profile::plain);
    fill_content(response, encoded->encoded, asset.levels.empty() ? 0 : geometry_bytes(asset.levels.front()));
    if (split.mode == proto::ShadingMode::hybrid && encoded->mode == proto::ShadingMode::gouraud &&
        split.distance > 0.0)
        response.warnings.push_back("sent all Gouraud: every split of this level would have been larger");

    Result<store::StoredFile> file =
        store.put_content(asset.id, key, "glb", encoded->encoded.glb, proto::to_json(response));
    if (!file) return file.error();
    response.content.url = bake::content_url(file->hash);
    return Nothing{};
}

// Where flat triangles save neither time nor, as the network is wide enough, bytes that are short.
bool hybrid_would_not_pay(const proto::PlanRequest& request, const budget::Budget& budget) {
    return request.shading == proto::ShadingMode::hybrid && budget.limited_by != budget::LimitedBy::network &&
           budget::gouraud_costs_no_more(request.budget.device);
}

Result<proto::PlanResponse> Planner::Impl::plan_level(const proto::PlanRequest& request, const proto::Asset& asset,
                                                      const LoadedAsset& loaded, const texture::Choice& textures,
                                                      const budget::Budget& budget) {
    proto::PlanResponse response;
    const Placement placement = place(request, loaded.world_bounds, budget.dlr);
    const bool all_gouraud = hybrid_would_not_pay(request, budget);
    const SplitRequest split{all_gouraud ? proto::ShadingMode::gouraud : request.shading, placement.distance,
                             placement.view};
    const bake::ShellView* shell =
        is_inside(placement.view.eye, loaded.world_bounds) ? nullptr : bake::shell_for(loaded.shells, budget.triangles);
    const LevelRequest wanted{budget.triangles, shell, split, textures, request.profile};
    if (Status added = add_content(response, asset, loaded, wanted); !added) return added.error();
    if (all_gouraud) response.warnings.push_back("sent all Gouraud: this device draws flat triangles hardly faster");
    fill_budget(response, budget);
    response.shading.distance = placement.distance;
    response.level.screen_space_error_px =
        seen_error(response).max * shading::pixels_per_unit(placement.view, loaded.world_bounds, placement.display);
    return response;
}

// While an asset bakes: what was made of it before, as it lies in the store. Nothing is kept of the answer.
Result<proto::PlanResponse> plan_first_level(const proto::PlanRequest& request, const proto::Asset& asset) {
    budget::AssetCost cost;
    cost.triangles = asset.triangles;
    for (const proto::Level& level : asset.levels) cost.sizes.push_back({level.triangles, level.bytes});
    const Result<budget::Budget> budget = budget::derive_budget(request.budget, cost);
    if (!budget) return budget.error();
    const proto::Level* level = find_first_level(asset, budget->triangles, budget::network_bytes(request.budget));
    if (!level) return not_ready(asset);

    proto::PlanResponse response;
    fill_budget(response, *budget);
    fill_first_level(response, *level, request);
    const Box bounds = world_bounds_of(asset);
    const Placement placement = place(request, bounds, budget->dlr);
    response.shading.distance = placement.distance;
    response.level.screen_space_error_px =
        level->max_error * shading::pixels_per_unit(placement.view, bounds, placement.display);
    return response;
}

Result<proto::PlanResponse> Planner::Impl::plan_triangles(const proto::PlanRequest& request, const proto::Asset& asset,
                                                          const LoadedAsset& loaded) {
    const texture::Choice textures =
        texture::choose(loaded.baked.model, loaded.textures, texture_needs(request, asset, loaded));
    budget::AssetCost cost = cost_of(asset, textures);
    for (int correction = 0;; ++correction) {
        Result<budget::Budget> budget = budget::derive_budget(request.budget, cost);
        if (!budget) return budget.error();
        Result<proto::PlanResponse> response = plan_level(request, asset, loaded, textures, *budget);
        if (!response) return response;
        const double excess = budget::network_excess(request.budget, cost, response->content.bytes);
        if (excess > 1.0 && budget->triangles > 1 && correction < max_network_corrections) {
            cost.bytes_factor *= excess * network_margin;
            continue;
        }
        return response;
    }
}

Sight sight_of(const proto::PlanRequest& request, const Box& world_bounds) {
    const shading::View view = view_of(request, world_bounds);
    return {shading::pixels_per_unit(view, world_bounds, display_of(request)),
            glm::length(view.eye - world_bounds.center()), world_bounds.radius()};
}

// A plan of points alone still tells the device's share and what it would get in triangles.
Result<proto::PlanResponse> Planner::Impl::plan_points(const proto::PlanRequest& request, const proto::Asset& asset,
                                                       const Box& world_bounds) {
    const Sight sight = sight_of(request, world_bounds);
    const Result<PointLevel> level = planner::plan_points(store, asset, request, sight);
    if (!level) return level.error();
    const Result<budget::Budget> budget = budget::derive_budget(request.budget, cost_of(asset, {}));
    if (!budget) return budget.error();
    proto::PlanResponse response;
    fill_budget(response, *budget);
    if (Status added = add_points(response, store, asset.id, *level, sight.pixels_per_unit); !added)
        return added.error();
    response.shading.distance = place(request, world_bounds, budget->dlr).distance;
    return response;
}

// The plan of triangles is at hand; points take its place where they win. An asset without points, or of which it was
// not measured what they show, keeps it.
Status Planner::Impl::choose_primitives(proto::PlanResponse& response, const proto::PlanRequest& request,
                                        const proto::Asset& asset, const LoadedAsset& loaded) {
    const auto kept = [](const Error& error) {
        return error.code == ErrorCode::not_found ? Status{Nothing{}} : Status{error};
    };
    const Sight sight = sight_of(request, loaded.world_bounds);
    const Result<PointLevel> level = planner::plan_points(store, asset, request, sight);
    if (!level) return kept(level.error());
    response.budget.points = level->budget.points;
    const Result<bake::ShownErrors> errors = bake::load_shown_errors(store, asset.id);
    if (!errors) return kept(errors.error());
    const double triangles_error = shown_error(*errors, response.shading.gouraud, response.shading.flat);
    response.crossing = crossing_of(*level, *errors, triangles_error, sight);
    if (!response.crossing || !points_win(*response.crossing)) return Nothing{};
    response.left_out.clear();
    response.timing_ms = {};
    return add_points(response, store, asset.id, *level, sight.pixels_per_unit);
}

Result<proto::PlanResponse> Planner::Impl::plan_baked(const proto::PlanRequest& request, const proto::Asset& asset) {
    if (asset.status != proto::AssetStatus::ready) return not_ready(asset);
    const bool is_cloud = asset.kind == mesh::kind_name(mesh::Kind::points);
    if (is_cloud && request.primitives == proto::Primitives::triangles) return no_triangles(asset);
    if (is_cloud || request.primitives == proto::Primitives::points)
        return plan_points(request, asset, world_bounds_of(asset));
    Result<std::shared_ptr<const LoadedAsset>> loaded = cache.load(asset.id);
    if (!loaded) return loaded.error();
    Result<proto::PlanResponse> response = plan_triangles(request, asset, **loaded);
    if (!response || request.primitives == proto::Primitives::triangles) return response;
    if (Status chosen = choose_primitives(*response, request, asset, **loaded); !chosen) return chosen.error();
    return response;
}

Result<proto::PlanResponse> Planner::Impl::plan(const proto::PlanRequest& request) {
    const Stopwatch watch;
    if (request.view)
        if (Status valid = shading::validate(*request.view); !valid) return valid.error();
    const Result<proto::Asset> asset = store.asset(request.asset);
    if (!asset) return asset.error();
    const bool has_first_levels = asset->status == proto::AssetStatus::baking && !asset->levels.empty();
    Result<proto::PlanResponse> response =
        has_first_levels ? plan_first_level(request, *asset) : plan_baked(request, *asset);
    if (response) response->timing_ms.plan = watch.ms();
    return response;
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
    if (asset->kind == mesh::kind_name(mesh::Kind::points)) return no_triangles(*asset);
    Result<std::shared_ptr<const LoadedAsset>> loaded = impl_->cache.load(asset->id);
    if (!loaded) return loaded.error();

    const mesh::Model& model = (*loaded)->baked.model;
    Cut result;
    const Stopwatch watch;
    result.model.mesh = simplify::cut((*loaded)->baked.history, triangles);
    result.cut_ms = watch.ms();
    result.model.materials = model.materials;
    result.model.images = model.images;
    result.model.origin = model.origin;
    result.model.kind = model.kind;
    result.model.objects = model.objects;
    result.error = bake::error_of((*loaded)->baked.errors, result.model.mesh.triangles.size());
    const texture::Choice textures = texture::choose(model, (*loaded)->textures, bake::level_needs(result.error));
    for (std::size_t i = 0; i < textures.images.size(); ++i)
        if (textures.images[i].image) result.model.images[i] = *textures.images[i].image;
    result.rms_error_percent = bake::percent_of_diagonal(result.error.rms, (*loaded)->baked.bounds);
    return result;
}

void Planner::forget(std::string_view asset_id) {
    impl_->cache.forget(std::string(asset_id));
}

}  // namespace lodestream::planner
