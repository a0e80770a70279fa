#include "client/report/shading_study.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "client/render/movable_level.h"
#include "common/base/directions.h"
#include "common/shading/importance.h"
#include "common/shading/paper_criterion.h"

namespace lodestream::report {
namespace {

constexpr double all_gouraud_share = 0.25;
constexpr double shares_of_price[] = {0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0};
constexpr double flat_shares[] = {0.0, 0.25, 0.5, 0.75, 1.0};
constexpr double pure_shares[] = {0.0, 1.0};
constexpr double paper_gouraud_share = 179.0 / 6400.0;  // of the phone's teapot
constexpr std::uint64_t printed_flat = 179, printed_gouraud = 4421, printed_triangles = 6400;
constexpr double unlimited_cpu_mhz = 1e9;
constexpr int max_byte_corrections = 4;  // a level's bytes do not fall in proportion with its triangles

std::uint64_t share_of(std::uint64_t count, double share) {
    return static_cast<std::uint64_t>(std::llround(share * static_cast<double>(count)));
}

std::vector<std::uint8_t> first_of(const std::vector<std::uint32_t>& order, std::uint64_t gouraud) {
    std::vector<std::uint8_t> labels(order.size(), 0);
    for (std::size_t i = 0; i < std::min<std::uint64_t>(gouraud, order.size()); ++i) labels[order[i]] = 1;
    return labels;
}

// The Gouraud primitives as one mesh.
mesh::Model merged(const codec::Decoded& content) {
    mesh::Model model;
    model.materials = content.materials;
    model.images = content.images;
    model.origin = content.origin;
    mesh::Mesh& out = model.mesh;
    bool colored = false, textured = false;
    for (const codec::Primitive& p : content.primitives) {
        colored = colored || !p.mesh.colors.empty();
        textured = textured || !p.mesh.texture_coordinates.empty();
    }
    for (const codec::Primitive& p : content.primitives) {
        const auto base = static_cast<std::uint32_t>(out.positions.size());
        out.positions.insert(out.positions.end(), p.mesh.positions.begin(), p.mesh.positions.end());
        out.normals.insert(out.normals.end(), p.mesh.normals.begin(), p.mesh.normals.end());
        out.normals.resize(out.positions.size(), Vec3f{0.0f});
        if (colored) {
            out.colors.insert(out.colors.end(), p.mesh.colors.begin(), p.mesh.colors.end());
            out.colors.resize(out.positions.size(), Rgba8(255));
        }
        if (textured) {
            out.texture_coordinates.insert(out.texture_coordinates.end(), p.mesh.texture_coordinates.begin(),
                                           p.mesh.texture_coordinates.end());
            out.texture_coordinates.resize(out.positions.size(), Vec2f{0.0f});
        }
        for (const mesh::Triangle& t : p.mesh.triangles) {
            out.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
            out.triangle_materials.push_back(p.material);
        }
    }
    return model;
}

// Which triangles are Gouraud.
enum class Criterion { paper, measured, in_view, from_anywhere };

std::string name_of(Criterion criterion) {
    switch (criterion) {
        case Criterion::paper:
            return "paper";
        case Criterion::measured:
            return "measured importance";
        case Criterion::in_view:
            return "importance";
        case Criterion::from_anywhere:
            return "importance from anywhere";
    }
    return "";
}

// A level, and what its shading is off the full model.
struct Judged {
    mesh::Model model;
    shading::NormalErrors errors;
};

class Study {
  public:
    Study(sdk::Client& client, render::Renderer& renderer, const std::vector<Setting>& settings,
          const shading::ReferenceSurface& full, const StudyOptions& options, AssetResult& asset)
        : client_(client), renderer_(renderer), settings_(settings), full_(full), options_(options), asset_(asset) {}

    Status run() {
        const std::uint64_t triangles = std::min(max_study_triangles, asset_.full_triangles);
        if (triangles < 4 || settings_.empty()) return Nothing{};
        if (Status done = equal_operations(std::min(max_study_operations, asset_.full_triangles / 2)); !done)
            return done;
        if (Status done = equal_bytes(triangles); !done) return done;
        Result<sdk::Loaded> level = load(triangles, proto::ShadingMode::gouraud);
        if (!level) return level.error();
        if (Status done = criteria(level->content); !done) return done;
        if (Status done = splits("lights", level->content, flat_shares); !done) return done;
        return options_.quick ? Status(Nothing{}) : fine_level();
    }

  private:
    // A level of at most so many triangles, for a device without limits.
    Result<sdk::Loaded> load(std::uint64_t triangles, proto::ShadingMode mode) {
        proto::PlanRequest request;
        request.asset = options_.asset_id;
        request.budget.device.cpu_mhz = unlimited_cpu_mhz;
        request.budget.preference.target_fps = budget::min_target_fps;
        request.budget.preference.triangles = std::max<std::uint64_t>(triangles, 1);
        request.shading = mode;
        request.view = options_.view;
        return client_.load(request);
    }

    // Draws what is on the GPU and adds it as a sample. `frames` 1: the time does not count.
    Status add(ShadingSample sample, const Setting& setting, std::uint32_t frames) {
        render::DrawOptions draw;
        draw.width = setting.display.width;
        draw.height = setting.display.height;
        draw.samples = 1;
        draw.frames = frames;
        draw.lights = light_rig(options_.view, setting.lights);
        Result<render::Frame> frame = renderer_.draw(options_.view, draw);
        if (!frame) return frame.error();
        Result<render::Difference> difference = render::compare(setting.full, frame->image);
        if (!difference) return difference.error();
        sample.lights = setting.lights;
        sample.display = setting.display;
        sample.triangles = sample.result.gouraud + sample.result.flat;
        sample.triangles_per_pixel = static_cast<double>(sample.triangles) /
                                     static_cast<double>(std::max<std::uint64_t>(difference->compared_pixels, 1));
        sample.operations = budget::with_shading(0, sample.result.gouraud, sample.result.flat).total;
        sample.result.frame_ms = frames > 1 ? frame->frame_ms : 0.0;
        sample.result.image = {100.0 * difference->rms / 255.0, difference->silhouette_percent};
        asset_.shading.push_back(std::move(sample));
        return Nothing{};
    }

    static ShadingSample sample_of(std::string series, std::string criterion, std::uint64_t triangles,
                                   std::uint64_t gouraud) {
        ShadingSample sample;
        sample.series = std::move(series);
        sample.criterion = std::move(criterion);
        sample.result.gouraud = std::min(gouraud, triangles);
        sample.result.flat = triangles - sample.result.gouraud;
        sample.result.mode = sample.result.flat == 0      ? proto::ShadingMode::gouraud
                             : sample.result.gouraud == 0 ? proto::ShadingMode::flat
                                                          : proto::ShadingMode::hybrid;
        return sample;
    }

    // Every mode with the triangles that it affords.
    Status equal_operations(std::uint64_t operations) {
        const Result<double> chosen = chosen_share(operations);
        if (!chosen) return chosen.error();
        if (Status added = add_bought(operations, *chosen, true); !added) return added;
        for (const double share : shares_of_price) {
            if (options_.quick && share > all_gouraud_share && share < 1.0) continue;
            if (Status added = add_bought(operations, share, false); !added) return added;
        }
        return Nothing{};
    }

    // Of what all flat affords, the triangles that are left where those worth it are Gouraud.
    Result<double> chosen_share(std::uint64_t operations) {
        Result<sdk::Loaded> level = load(operations, proto::ShadingMode::gouraud);
        if (!level) return level.error();
        const Judged judged = judge(level->content);
        const auto worth = static_cast<double>(shading::worth_gouraud(importance(judged, Criterion::measured)));
        constexpr double further = budget::gouraud_operations - budget::flat_operations;
        return std::max(all_gouraud_share, 1.0 - further * worth / static_cast<double>(operations));
    }

    Status add_bought(std::uint64_t operations, double share, bool is_chosen) {
        const Purchase bought = purchase(operations, share);
        Result<sdk::Loaded> level = load(bought.triangles, proto::ShadingMode::gouraud);
        if (!level) return level.error();
        const Judged judged = judge(level->content);
        for (const Criterion criterion : {Criterion::measured, Criterion::paper}) {
            const bool has_choice = is_chosen || (share > all_gouraud_share && share < 1.0);
            if (criterion == Criterion::paper && !has_choice) continue;
            const auto order = order_by(judged, criterion);
            if (Status up = upload_split(judged.model, order, bought.gouraud); !up) return up;
            ShadingSample sample = sample_of("equal operations", name_of(criterion), order.size(), bought.gouraud);
            sample.share_of_price = share;
            sample.is_chosen = is_chosen;
            if (Status added = add(std::move(sample), settings_.front(), 1); !added) return added;
        }
        return Nothing{};
    }

    // All flat as the server sends it, and all Gouraud with as many triangles as take no more bytes.
    Status equal_bytes(std::uint64_t triangles) {
        Result<sdk::Loaded> flat = load(triangles, proto::ShadingMode::flat);
        if (!flat) return flat.error();
        Result<sdk::Loaded> smooth = load(triangles, proto::ShadingMode::gouraud);
        for (int i = 0; smooth && smooth->bytes > flat->bytes && i < max_byte_corrections; ++i) {
            const double ratio = static_cast<double>(flat->bytes) / static_cast<double>(smooth->bytes);
            triangles = share_of(triangles, ratio);
            smooth = load(triangles, proto::ShadingMode::gouraud);
        }
        if (!smooth) return smooth.error();
        for (const sdk::Loaded* level : {&*flat, &*smooth}) {
            if (auto up = renderer_.upload(level->content); !up) return up.error();
            ShadingSample sample =
                sample_of("equal bytes", "", level->plan.level.triangles, level->plan.shading.gouraud);
            sample.result.bytes = level->bytes;
            if (Status added = add(std::move(sample), settings_.front(), 1); !added) return added;
        }
        return Nothing{};
    }

    // The same level split after each criterion.
    Status criteria(const codec::Decoded& content) {
        const Judged judged = judge(content);
        for (const Criterion criterion :
             {Criterion::paper, Criterion::measured, Criterion::in_view, Criterion::from_anywhere}) {
            const auto order = order_by(judged, criterion);
            for (const double flat : flat_shares) {
                const std::uint64_t gouraud = share_of(order.size(), 1.0 - flat);
                if (Status up = upload_split(judged.model, order, gouraud); !up) return up;
                ShadingSample sample = sample_of("criteria", name_of(criterion), order.size(), gouraud);
                sample.distance = flat;
                if (Status added = add(std::move(sample), settings_.front(), 1); !added) return added;
            }
        }
        return Nothing{};
    }

    // The pure modes of a level with more triangles a pixel, unless the model has no more.
    Status fine_level() {
        const std::uint64_t triangles = std::min(max_fine_triangles, asset_.full_triangles);
        if (triangles <= max_study_triangles) return Nothing{};
        Result<sdk::Loaded> level = load(triangles, proto::ShadingMode::gouraud);
        if (!level) return level.error();
        return splits("fine level", level->content, pure_shares);
    }

    // The border moves over one upload, in every setting.
    Status splits(const char* series, const codec::Decoded& content, std::span<const double> shares) {
        Result<render::MovableLevel> level = render::movable_level(content);
        if (!level) return level.error();
        Result<render::UploadStatistics> uploaded = renderer_.upload(*level);
        if (!uploaded) return uploaded.error();
        for (const Setting& setting : settings_)
            for (const double flat : shares) {
                const std::uint64_t gouraud = share_of(level->triangles(), 1.0 - flat);
                renderer_.move_split(gouraud);
                ShadingSample sample =
                    sample_of(series, name_of(Criterion::from_anywhere), level->triangles(), gouraud);
                sample.distance = flat;
                sample.result.gpu_bytes = uploaded->geometry_bytes + uploaded->texture_bytes;
                if (Status added = add(std::move(sample), setting, options_.frames); !added) return added;
            }
        return Nothing{};
    }

    Judged judge(const codec::Decoded& content) const {
        Judged judged{merged(content), {}};
        judged.errors = shading::normal_errors(judged.model.mesh, full_);
        return judged;
    }

    // pre: not the paper's
    shading::Importance importance(const Judged& judged, Criterion criterion) const {
        shading::ImportanceOptions options;
        options.origin = judged.model.origin;
        if (criterion != Criterion::from_anywhere) options.view = options_.view;
        if (criterion == Criterion::measured) options.errors = &judged.errors;
        return shading::importance(judged.model.mesh, judged.model.materials, options);
    }

    std::vector<std::uint32_t> order_by(const Judged& judged, Criterion criterion) const {
        const mesh::Model& model = judged.model;
        return criterion == Criterion::paper
                   ? shading::paper_criterion(model.mesh, model.materials, options_.view, model.origin).order
                   : shading::order_by_gain(importance(judged, criterion).gain);
    }

    Status upload_split(const mesh::Model& model, const std::vector<std::uint32_t>& order, std::uint64_t gouraud) {
        auto uploaded = renderer_.upload(render::drawable(model, model.mesh, first_of(order, gouraud)));
        return uploaded ? Status(Nothing{}) : Status(uploaded.error());
    }

    sdk::Client& client_;
    render::Renderer& renderer_;
    const std::vector<Setting>& settings_;
    const shading::ReferenceSurface& full_;
    const StudyOptions& options_;
    AssetResult& asset_;
};

}  // namespace

Purchase purchase(std::uint64_t operations, double share) {
    Purchase bought;
    bought.triangles = std::max<std::uint64_t>(share_of(operations, std::clamp(share, all_gouraud_share, 1.0)), 1);
    const std::uint64_t left = operations > bought.triangles ? operations - bought.triangles : 0;
    bought.gouraud = std::min(bought.triangles, left / (budget::gouraud_operations - budget::flat_operations));
    return bought;
}

std::vector<render::Light> light_rig(const shading::View& view, std::size_t count) {
    std::vector<render::Light> lights;
    for (std::size_t i = 0; i < count; ++i) {
        const Vec3d direction = i == 0 ? view.light : spread_direction(i, count);
        lights.push_back({direction, 1.0 / static_cast<double>(count)});
    }
    return lights;
}

Result<std::vector<Setting>> study_settings(render::Renderer& renderer, const shading::View& view, bool quick) {
    constexpr budget::Display usual{800, 600};
    std::vector<Setting> settings;
    for (const std::uint32_t lights : {1u, 4u, 16u, 64u}) settings.push_back({lights, usual, {}});
    if (!quick)
        for (const budget::Display display : {budget::Display{320, 240}, budget::Display{1280, 1024}})
            for (const std::uint32_t lights : {1u, 4u, 16u, 64u}) settings.push_back({lights, display, {}});
    for (Setting& setting : settings) {
        render::DrawOptions draw;
        draw.width = setting.display.width;
        draw.height = setting.display.height;
        draw.samples = 1;
        draw.lights = light_rig(view, setting.lights);
        Result<render::Frame> frame = renderer.draw(view, draw);
        if (!frame) return frame.error();
        setting.full = std::move(frame->image);
    }
    return settings;
}

Status study_shading(sdk::Client& client, render::Renderer& renderer, const std::vector<Setting>& settings,
                     const shading::ReferenceSurface& full, const StudyOptions& options, AssetResult& asset) {
    return Study(client, renderer, settings, full, options, asset).run();
}

shading::ReferenceSurface reference_surface(const codec::Decoded& full) {
    return shading::ReferenceSurface(merged(full).mesh);
}

CountedOperations count_operations(const codec::Decoded& full, const shading::View& view) {
    const mesh::Model model = merged(full);
    const std::uint64_t n = model.mesh.triangles.size();
    const shading::PaperCriterion criterion = shading::paper_criterion(model.mesh, model.materials, view, model.origin);
    const auto total = [&](std::uint64_t gouraud, std::uint64_t flat) {
        std::vector<std::uint8_t> labels(gouraud, 1);
        labels.resize(gouraud + flat, 0);
        return criterion.operations.criterion() + shading::paper_normals(model.mesh, labels).operations.shading();
    };
    CountedOperations counted;
    counted.triangles = n;
    counted.differing = criterion.differing;
    counted.criterion = criterion.operations.criterion();
    counted.all_flat = total(0, n);
    counted.all_gouraud = total(n, 0);
    const std::uint64_t gouraud = share_of(n, paper_gouraud_share);
    counted.hybrid = total(gouraud, n - gouraud);
    if (n == printed_triangles) counted.hybrid_as_printed = total(printed_gouraud, printed_flat);
    return counted;
}

}  // namespace lodestream::report
