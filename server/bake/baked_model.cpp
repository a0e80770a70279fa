// The stored form of a baked model, little-endian:
//   magic "LODBAKE3", then the fields below in order, as stored_form.h says. The history's are arrays.
//   "LODBAKE2" is the same but for older errors, and still read.
#include "server/bake/baked_model.h"

#include <algorithm>
#include <cmath>

#include "common/mesh/operations.h"
#include "server/bake/stored_form.h"

namespace lodestream::bake {

namespace {

constexpr std::string_view magic = "LODBAKE3", older_magic = "LODBAKE2";

template <class Stream, class Baked, class Errors>
void describe_all(Stream& stream, Baked& baked, const Errors& describe_errors) {
    auto& model = baked.model;
    stream(model.materials);
    stream(model.images);
    stream(model.origin);
    stream(model.kind);
    stream(model.objects);
    stream(baked.bounds);
    stream(baked.grid_bounds);
    stream(baked.image_uses);
    stream(baked.texel_sizes);
    describe_errors(stream, baked.errors);
    auto& history = baked.history;
    stream.array(history.steps);
    stream.array(history.positions);
    stream.array(history.normals);
    stream.array(history.texture_coordinates);
    stream.array(history.colors);
    stream.array(history.changed_vertices);
    stream.array(history.moved_corners);
    stream.array(history.moved_corner_ends);
    stream.array(history.triangles);
    stream.array(history.triangle_materials);
}

Error damaged(const std::string& what) {
    return fail(ErrorCode::invalid_input, "baked model is damaged: " + what);
}

bool finite(const Box& box) {
    return all_finite(box.min) && all_finite(box.max);
}

Status validate_materials(const BakedView& baked) {
    const mesh::Model& model = baked.model;
    for (const std::uint32_t material : baked.history.triangle_materials)
        if (material >= model.materials.size()) return damaged("a triangle names a material that is not there");
    if (model.materials.empty()) return damaged("it has no material");
    for (const mesh::Material& material : model.materials)
        for (const mesh::TextureReference* texture :
             {&material.base_color_texture, &material.metallic_roughness_texture, &material.occlusion_texture,
              &material.emissive_texture})
            if (texture->image >= static_cast<int>(model.images.size()))
                return damaged("a material names an image that is not there");
    if (baked.image_uses.size() != model.images.size() || baked.texel_sizes.size() != model.images.size())
        return damaged("image counts differ");
    return Nothing{};
}

Status validate(const BakedView& baked) {
    if (!all_finite(baked.model.origin) || !finite(baked.bounds) || !finite(baked.grid_bounds))
        return damaged("numbers are not finite");
    if (baked.history.steps.empty()) return damaged("it has no level");
    if (Status valid = validate_errors(baked.errors); !valid) return valid.error();
    if (Status valid = simplify::validate(baked.history); !valid) return damaged(valid.error().message);
    return validate_materials(baked);
}

}  // namespace

Status validate_errors(const std::vector<ErrorSample>& errors) {
    if (errors.empty()) return damaged("it has no measured error");
    for (std::size_t i = 0; i < errors.size(); ++i) {
        const ErrorSample& sample = errors[i];
        const auto& [rms, max, normal_degrees] = sample.error;
        if (!std::isfinite(rms) || !std::isfinite(max) || !std::isfinite(normal_degrees) || rms < 0)
            return damaged("an error is no number");
        if (i > 0 && sample.triangles >= errors[i - 1].triangles) return damaged("its errors are not in order");
    }
    return Nothing{};
}

BakedModel describe_model(const mesh::Model& model) {
    BakedModel baked;
    baked.bounds = mesh::bounds(model.mesh);
    baked.image_uses = texture::image_uses(model);
    baked.texel_sizes = texture::texel_sizes(model);
    baked.model.materials = model.materials;
    baked.model.images = model.images;
    baked.model.origin = model.origin;
    baked.model.kind = model.kind;
    baked.model.objects = model.objects;
    return baked;
}

void set_history(BakedModel& baked, simplify::History history) {
    for (const Vec3f& p : history.positions) baked.grid_bounds.add(Vec3d(p));
    baked.history = std::move(history);
}

std::vector<ErrorSample> in_order(std::vector<ErrorSample> samples) {
    std::sort(samples.begin(), samples.end(),
              [](const ErrorSample& a, const ErrorSample& b) { return a.triangles > b.triangles; });
    const auto same = [](const ErrorSample& a, const ErrorSample& b) { return a.triangles == b.triangles; };
    samples.erase(std::unique(samples.begin(), samples.end(), same), samples.end());
    metric::SurfaceError worst;
    for (ErrorSample& sample : samples) {
        worst.rms = sample.error.rms = std::max(worst.rms, sample.error.rms);
        worst.max = sample.error.max = std::max(worst.max, sample.error.max);
    }
    return samples;
}

std::vector<std::byte> serialize(const BakedModel& baked) {
    Writer writer;
    writer.magic(magic);
    describe_all(writer, baked, [](Writer& stream, const auto& errors) { stream(errors); });
    return std::move(writer.bytes);
}

Result<BakedView> open_baked_model(std::span<const std::byte> bytes) {
    const bool is_older = Reader(bytes).magic(older_magic);
    Reader reader(bytes);
    if (!reader.magic(magic) && !is_older) return damaged("it does not start with LODBAKE3");
    BakedView baked;
    describe_all(reader, baked, [&](Reader& stream, std::vector<ErrorSample>& errors) {
        is_older ? read_older_errors(stream, errors) : stream(errors);
    });
    if (!reader.ok()) return damaged("it ends too early");
    if (!reader.at_end()) return damaged("bytes follow its end");
    if (Status valid = validate(baked); !valid) return valid.error();
    return baked;
}

metric::SurfaceError error_of(std::span<const ErrorSample> errors, std::uint64_t triangles) {
    // The first sample that is not finer.
    const auto coarser = std::lower_bound(errors.begin(), errors.end(), triangles,
                                          [](const ErrorSample& s, std::uint64_t n) { return s.triangles > n; });
    if (coarser == errors.end()) return errors.back().error;
    metric::SurfaceError error = coarser->error;
    if (coarser != errors.begin() && coarser->triangles > 0) {
        const ErrorSample& finer = *std::prev(coarser);
        const auto octaves = [&](std::uint64_t n) { return std::log2(double(n) / double(coarser->triangles)); };
        error.normal_degrees =
            std::lerp(error.normal_degrees, finer.error.normal_degrees, octaves(triangles) / octaves(finer.triangles));
    }
    return error;
}

}  // namespace lodestream::bake
