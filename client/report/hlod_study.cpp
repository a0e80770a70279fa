#include "client/report/hlod_study.h"

#include <algorithm>
#include <map>

#include "common/scene/select.h"

namespace lodestream::report {
namespace {

constexpr double near_share = 1e-3;  // of the distance to what is looked at

scene::View scene_view(const shading::View& from, const render::Image& canvas) {
    scene::View view = scene::view_towards(from.eye, from.target);
    view.fov_y_deg = from.fov_y_deg;
    view.width = canvas.width;
    view.height = canvas.height;
    view.near = near_share * distance(from.eye, from.target);
    return view;
}

// Behind what is there already. pre: the same origin
void append(codec::Decoded& to, const codec::Decoded& tile) {
    const auto first_material = static_cast<std::uint32_t>(to.materials.size());
    const auto first_image = static_cast<int>(to.images.size());
    for (mesh::Material material : tile.materials) {
        for (mesh::TextureReference* texture : {&material.base_color_texture, &material.metallic_roughness_texture,
                                                &material.occlusion_texture, &material.emissive_texture})
            if (texture->image >= 0) texture->image += first_image;
        to.materials.push_back(std::move(material));
    }
    to.images.insert(to.images.end(), tile.images.begin(), tile.images.end());
    for (codec::Primitive primitive : tile.primitives) {
        primitive.material += first_material;
        to.primitives.push_back(std::move(primitive));
    }
    to.origin = tile.origin;
}

class Tiles {
  public:
    Tiles(sdk::Client& client, proto::Tileset tileset) : client_(client), tileset_(std::move(tileset)) {}

    const scene::LodTree& tree() const { return tileset_.nodes; }

    Result<codec::Decoded> joined(const std::vector<std::uint32_t>& tiles) {
        codec::Decoded all;
        for (const std::uint32_t tile : tiles) {
            auto known = decoded_.find(tile);
            if (known == decoded_.end()) {
                Result<std::vector<std::byte>> glb = client_.fetch(tileset_.uris[tile], tileset_.bytes[tile]);
                if (!glb) return glb.error();
                Result<codec::Decoded> decoded = codec::decode_level(*glb);
                if (!decoded) return decoded.error();
                known = decoded_.emplace(tile, *std::move(decoded)).first;
            }
            append(all, known->second);
        }
        return all;
    }
    std::uint64_t bytes(const std::vector<std::uint32_t>& tiles) const {
        std::uint64_t sum = 0;
        for (const std::uint32_t tile : tiles) sum += tileset_.bytes[tile];
        return sum;
    }

  private:
    sdk::Client& client_;
    proto::Tileset tileset_;
    std::map<std::uint32_t, codec::Decoded> decoded_;
};

// Draws contents in one view and compares them with the full model's picture.
class Judge {
  public:
    Judge(render::Renderer& renderer, const shading::View& view, const render::Image& full, std::uint32_t frames)
        : renderer_(renderer), view_(view), full_(full) {
        drawing_.width = full.width;
        drawing_.height = full.height;
        drawing_.samples = 1;
        drawing_.frames = std::max(1u, frames);
    }

    // Adds it, unless it has as many triangles as the last one.
    Status add(const codec::Decoded& content, HlodSample sample, std::vector<HlodSample>& samples) {
        if (auto uploaded = renderer_.upload(content); !uploaded) return uploaded.error();
        const Result<render::Frame> frame = renderer_.draw(view_, drawing_);
        if (!frame) return frame.error();
        const Result<render::Difference> difference = render::compare(full_, frame->image);
        if (!difference) return difference.error();
        sample.triangles = frame->triangles;
        sample.frame_ms = frame->frame_ms;
        sample.image = {100.0 * difference->rms / 255.0, difference->silhouette_percent};
        const bool is_new = samples.empty() || samples.back().triangles != sample.triangles;
        if (is_new) samples.push_back(sample);
        return Nothing{};
    }

  private:
    render::Renderer& renderer_;
    const shading::View& view_;
    const render::Image& full_;
    render::DrawOptions drawing_;
};

Status study_tiles(Tiles& tiles, const scene::View& seen, Judge& judge, std::vector<HlodSample>& samples) {
    for (const std::uint64_t budget : hlod_budgets) {
        scene::SelectOptions options;
        options.budget = budget;
        const scene::Selection selection = scene::select(tiles.tree(), seen, options);
        HlodSample sample;
        sample.budget = budget;
        sample.tiles = selection.nodes.size();
        sample.bytes = tiles.bytes(selection.nodes);
        sample.error_px = selection.largest_error_px;
        const Result<codec::Decoded> content = tiles.joined(selection.nodes);
        if (!content) return content.error();
        if (Status added = judge.add(*content, sample, samples); !added) return added;
    }
    return Nothing{};
}

Status study_plans(sdk::Client& client, proto::PlanRequest request, Judge& judge, std::vector<HlodSample>& samples) {
    for (const std::uint64_t budget : hlod_budgets) {
        request.budget.preference.triangles = budget;
        const Result<sdk::Loaded> loaded = client.load(request);
        if (!loaded) return loaded.error();
        HlodSample sample;
        sample.budget = budget;
        sample.bytes = loaded->plan.content.bytes;
        sample.error_px = loaded->plan.level.screen_space_error_px;
        if (Status added = judge.add(loaded->content, sample, samples); !added) return added;
    }
    return Nothing{};
}

}  // namespace

Status study_hlod(sdk::Client& client, render::Renderer& renderer, const proto::PlanRequest& request,
                  const render::Image& full, std::uint32_t frames, AssetResult& result) {
    Result<proto::Tileset> tileset = client.tileset(result.asset.id);
    if (!tileset) return tileset.error();
    if (tileset->is_additive) return fail(ErrorCode::unsupported, "its tiles are points");
    Tiles tiles(client, *std::move(tileset));
    const scene::View seen = scene_view(*request.view, full);
    if (Status valid = scene::validate(seen); !valid) return valid.error();
    Judge judge(renderer, *request.view, full, frames);
    if (Status studied = study_tiles(tiles, seen, judge, result.hlod); !studied) return studied;
    return study_plans(client, request, judge, result.plans);
}

}  // namespace lodestream::report
