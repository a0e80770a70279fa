// The stored form: magic "LODSHOW1", then the three lists, as stored_form.h says.
#include "server/bake/shown_errors.h"

#include <algorithm>
#include <cmath>

#include "common/points/pictures.h"
#include "server/bake/stored_form.h"

namespace lodestream::bake {

namespace {

constexpr std::string_view magic = "LODSHOW1";

std::vector<std::uint64_t> counts_up_to(std::uint64_t all) {
    std::vector<std::uint64_t> counts;
    for (std::uint64_t count = 1; count < all && count <= finest_shown; count *= 2) counts.push_back(count);
    if (all > 0) counts.push_back(all);
    return counts;
}

std::vector<ShownError> unmeasured(std::uint64_t all) {
    std::vector<ShownError> errors;
    for (const std::uint64_t count : counts_up_to(all)) errors.push_back({count, 0.0});
    return errors;
}

// One description serves reading and writing.
template <class Stream, class Errors>
void describe_errors(Stream& stream, Errors& errors) {
    stream(errors.gouraud);
    stream(errors.flat);
    stream(errors.points);
}

bool is_sound(const std::vector<ShownError>& errors) {
    std::uint64_t before = 0;
    return std::ranges::all_of(errors, [&](const ShownError& e) {
        return std::isfinite(e.error) && e.error >= 0.0 && std::exchange(before, e.count) < e.count;
    });
}

}  // namespace

double error_at(std::span<const ShownError> errors, std::uint64_t count) {
    if (errors.empty()) return 0.0;
    const auto finer = std::ranges::lower_bound(errors, count, {}, &ShownError::count);
    if (finer == errors.end()) return errors.back().error;
    if (finer == errors.begin() || finer->count == count) return finer->error;
    const ShownError& coarser = *(finer - 1);
    if (!(coarser.error > 0.0 && finer->error > 0.0)) return coarser.error;
    const auto log = [](std::uint64_t n) { return std::log(static_cast<double>(n)); };
    const double share = (log(count) - log(coarser.count)) / (log(finer->count) - log(coarser.count));
    return std::exp(std::lerp(std::log(coarser.error), std::log(finer->error), share));
}

ShownErrors measure_shown_errors(const ShownSource& source, const simplify::Executor& executor) {
    const bool is_colored = !source.colors.constant();
    const auto surface_of = [&](const mesh::Mesh& mesh, bool is_flat) {
        points::Surface surface{mesh, {}, is_flat};
        if (is_colored)
            surface.color = [colors = source.colors.on(mesh)](std::size_t t, const Vec3f& w) {
                return colors.at(t, w);
            };
        return surface;
    };
    const points::Pictures pictures(surface_of(source.finest, false), executor);
    ShownErrors errors;
    errors.gouraud = errors.flat = unmeasured(source.finest.triangles.size());
    errors.points = unmeasured(source.cloud.positions.size());
    const std::size_t meshes = errors.gouraud.size();
    simplify::run(executor, meshes + errors.points.size(), [&](std::size_t k) {
        if (k < meshes) {
            const mesh::Mesh level = simplify::cut(source.history, errors.gouraud[k].count);
            errors.gouraud[k].error = pictures.error(surface_of(level, false));
            errors.flat[k].error = pictures.error(surface_of(level, true));
        } else {
            ShownError& level = errors.points[k - meshes];
            const double radius = points::level_of(source.levels, level.count).radius;
            level.error = pictures.error(points::Discs{source.cloud, level.count, radius});
        }
    });
    return errors;
}

Status put_shown_errors(store::Store& store, const std::string& asset_id, const ShownErrors& errors) {
    Writer writer;
    writer.magic(magic);
    describe_errors(writer, errors);
    const auto stored = store.put_content(asset_id, shown_errors_key, "shown", writer.bytes);
    return stored ? Status{Nothing{}} : Status{stored.error()};
}

Result<ShownErrors> load_shown_errors(const store::Store& store, const std::string& asset_id) {
    const Result<store::Store::Content> stored = store.content(asset_id, shown_errors_key);
    if (!stored) return stored.error();
    const Result<std::vector<std::byte>> bytes = store::read_file(stored->file.path, max_shown_bytes);
    if (!bytes) return bytes.error();
    Reader reader(*bytes);
    ShownErrors errors;
    const bool is_one = reader.magic(magic);
    describe_errors(reader, errors);
    if (!is_one || !reader.ok() || !reader.at_end() || !is_sound(errors.gouraud) || !is_sound(errors.flat) ||
        !is_sound(errors.points))
        return invalid_input("the stored errors of pictures are damaged");
    return errors;
}

}  // namespace lodestream::bake
