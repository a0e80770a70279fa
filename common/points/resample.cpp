#include "common/points/resample.h"

#include <algorithm>
#include <cmath>

#include "common/mesh/operations.h"
#include "common/mesh/outside.h"
#include "common/points/view.h"

namespace lodestream::points {

namespace {

constexpr std::size_t triangles_in_run = 1u << 16;
constexpr std::size_t samples_in_run = 1u << 16;
constexpr double cells_along_extent = 128.0;  // that tell what is hidden inside
constexpr double px_per_cell = 2.0;           // at least, so that a surface leaves no gap between its cells

// The mesh's box in pixels: p = (position - low) * px_per_unit.
struct Raster {
    Vec3d low{0.0};
    double px_per_unit = 1.0;
    Vec3d extent_px{0.0};
    double slice_px = 1.0;
    std::uint32_t slices = 1;

    Vec3d to_px(const Vec3f& position) const { return (Vec3d(position) - low) * px_per_unit; }
    std::uint32_t pixels(int axis) const { return static_cast<std::uint32_t>(extent_px[axis]) + 1; }
    ViewSize view(std::size_t axis) const {
        return {pixels(view_axes[axis][0]), pixels(view_axes[axis][1]), slice_px, slices};
    }
};

double longest_side(const Box& box) {
    const Vec3d extent = box.extent();
    return std::max({extent.x, extent.y, extent.z});
}

Raster raster_of(const Box& box, const Parameters& parameters) {
    Raster raster;
    raster.low = box.min;
    const double longest = longest_side(box), side = std::clamp(parameters.side, 1u, max_side);
    if (longest > 0.0) raster.px_per_unit = side / longest;
    raster.extent_px = min(box.extent() * raster.px_per_unit, Vec3d(side));
    raster.slices = std::clamp(parameters.slices, 1u, max_slices);
    raster.slice_px = side / raster.slices;
    return raster;
}

using Corners = std::array<Vec3d, 3>;

Corners corners_px(const mesh::Mesh& mesh, std::size_t triangle, const Raster& raster) {
    const mesh::Triangle& t = mesh.triangles[triangle];
    return {raster.to_px(mesh.positions[t[0]]), raster.to_px(mesh.positions[t[1]]), raster.to_px(mesh.positions[t[2]])};
}

Corners seen_along(const Corners& corners, std::size_t axis) {
    const auto [x, y, depth] = view_axes[axis];
    Corners seen;
    for (std::size_t k = 0; k < 3; ++k) seen[k] = {corners[k][x], corners[k][y], corners[k][depth]};
    return seen;
}

// The axis that sees most of the triangle.
std::size_t facing_axis(const Corners& c) {
    const Vec3d normal = abs(cross(c[1] - c[0], c[2] - c[0]));
    return normal.x >= normal.y && normal.x >= normal.z ? 0 : normal.y >= normal.z ? 1 : 2;
}

using Hits = std::array<std::vector<Hit>, 3>;  // one an axis

void draw_as_point(const Corners& corners, std::uint32_t triangle, const Raster& raster, Hits& hits) {
    const std::size_t axis = facing_axis(corners);
    const ViewSize size = raster.view(axis);
    const Corners seen = seen_along(corners, axis);
    const Vec3d center = (seen[0] + seen[1] + seen[2]) / 3.0;
    const auto x = std::min(static_cast<std::uint32_t>(std::max(center.x, 0.0)), size.width - 1);
    const auto y = std::min(static_cast<std::uint32_t>(std::max(center.y, 0.0)), size.height - 1);
    hits[axis].push_back({y * size.width + x, static_cast<float>(center.z), triangle | drawn_as_point});
}

// Where a triangle is seen along an axis; false: edge-on.
bool hit_at(const Corners& seen, std::uint32_t pixel, std::uint32_t triangle, const ViewSize& size, Hit& hit) {
    Vec3d w;
    const std::uint32_t column = pixel % size.width, row = pixel / size.width;
    if (!weights_at(seen, column + 0.5, row + 0.5, w)) return false;
    const double depth = w.x * seen[0].z + w.y * seen[1].z + w.z * seen[2].z;
    hit = {pixel, static_cast<float>(depth), triangle};
    return true;
}

// Calls emit(axis, hit) for every pixel of every view; returns whether there was one.
template <class Emit>
bool for_each_hit(const Corners& corners, std::uint32_t triangle, const Raster& raster, const Emit& emit) {
    bool is_hit = false;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const Corners seen = seen_along(corners, axis);
        const ViewSize size = raster.view(axis);
        for_each_pixel(seen, size.width, size.height, [&](std::uint32_t x, std::uint32_t y) {
            Hit hit;
            if (!hit_at(seen, y * size.width + x, triangle, size, hit)) return;
            emit(axis, hit);
            is_hit = true;
        });
    }
    return is_hit;
}

void draw(const mesh::Mesh& mesh, std::size_t triangle, const Raster& raster, Hits& hits) {
    const Corners corners = corners_px(mesh, triangle, raster);
    const auto number = static_cast<std::uint32_t>(triangle);
    const auto add = [&](std::size_t axis, const Hit& hit) { hits[axis].push_back(hit); };
    if (!for_each_hit(corners, number, raster, add)) draw_as_point(corners, number, raster, hits);
}

Hits draw_all(const mesh::Mesh& mesh, const Raster& raster, const simplify::Executor& executor) {
    const std::size_t count = mesh.triangles.size();
    std::vector<Hits> parts((count + triangles_in_run - 1) / triangles_in_run);
    simplify::for_each_run(executor, count, triangles_in_run, [&](std::size_t begin, std::size_t end) {
        for (std::size_t t = begin; t < end; ++t) draw(mesh, t, raster, parts[begin / triangles_in_run]);
    });
    Hits all;
    simplify::run(executor, 3, [&](std::size_t axis) {
        for (Hits& part : parts) {
            all[axis].insert(all[axis].end(), part[axis].begin(), part[axis].end());
            std::vector<Hit>().swap(part[axis]);
        }
    });
    return all;
}

// By views that another draws. A triangle that none of them shows may be hidden, or lie between the centres of all
// pixels, or have centres just on its edge, which a GPU gives to one side only: there it counts where nothing else is.
Result<Hits> draw_all(const mesh::Mesh& mesh, const Raster& raster, const DrawSlices& draw_slices) {
    Hits hits;
    std::array<std::vector<std::uint8_t>, 3> is_filled;
    std::vector<std::array<Vec3f, 3>> triangles(mesh.triangles.size());
    std::vector<std::uint8_t> is_seen(mesh.triangles.size(), 0);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::size_t t = 0; t < triangles.size(); ++t) {
            const Corners seen = seen_along(corners_px(mesh, t, raster), axis);
            triangles[t] = {Vec3f(seen[0]), Vec3f(seen[1]), Vec3f(seen[2])};
        }
        const ViewSize size = raster.view(axis);
        const auto drawn = draw_slices({size, triangles});
        if (!drawn) return drawn.error();
        is_filled[axis].assign(std::size_t{size.width} * size.height, 0);
        for (const Seen& seen : *drawn) {
            if (seen.pixel >= is_filled[axis].size() || seen.triangle >= triangles.size())
                return fail(ErrorCode::internal, "a slice shows a pixel or a triangle that is not there");
            is_seen[seen.triangle] = is_filled[axis][seen.pixel] = 1;
            Hit hit;
            const Corners corners = seen_along(corners_px(mesh, seen.triangle, raster), axis);
            if (hit_at(corners, seen.pixel, seen.triangle, size, hit)) hits[axis].push_back(hit);
        }
    }
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        if (is_seen[t]) continue;
        const Corners corners = corners_px(mesh, t, raster);
        const auto number = static_cast<std::uint32_t>(t);
        const auto add_where_empty = [&](std::size_t axis, const Hit& hit) {
            if (!is_filled[axis][hit.pixel]) hits[axis].push_back(hit);
        };
        if (!for_each_hit(corners, number, raster, add_where_empty)) draw_as_point(corners, number, raster, hits);
    }
    return hits;
}

// Where a sample lies in pixels, and the weights of its triangle's corners there.
struct Place {
    Vec3d px{0.0};
    Vec3d weights{1.0 / 3.0};
};

Place place_of(const Sample& sample, std::size_t axis, const Corners& corners, const Raster& raster) {
    const std::uint32_t width = raster.view(axis).width;
    const std::uint32_t column = sample.hit.pixel % width, row = sample.hit.pixel / width;
    const double x = column + 0.5, y = row + 0.5;
    Place place;
    if (!(sample.hit.triangle & drawn_as_point)) weights_at(seen_along(corners, axis), x, y, place.weights);
    place.px = place.weights.x * corners[0] + place.weights.y * corners[1] + place.weights.z * corners[2];
    if (!sample.fills_a_hole) return place;
    const auto [x_axis, y_axis, depth_axis] = view_axes[axis];
    place.px[x_axis] = x;
    place.px[y_axis] = y;
    place.px[depth_axis] = sample.hit.depth;
    return place;
}

struct Samples {
    std::vector<Sample> samples;
    std::vector<std::uint8_t> axes;  // one a sample
    std::vector<Vec3f> px;           // likewise
};

Samples sample_views(const mesh::Mesh& mesh, Hits hits, const Raster& raster, const ResampleOptions& options) {
    std::array<std::vector<Sample>, 3> parts;
    simplify::run(options.executor, 3, [&](std::size_t axis) {
        parts[axis] = sampled(std::move(hits[axis]), raster.view(axis), options.filter);
    });
    Samples all;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        all.samples.insert(all.samples.end(), parts[axis].begin(), parts[axis].end());
        all.axes.resize(all.samples.size(), static_cast<std::uint8_t>(axis));
    }
    all.px.resize(all.samples.size());
    simplify::for_each_run(
        options.executor, all.samples.size(), samples_in_run, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const std::uint32_t triangle = all.samples[i].hit.triangle & ~drawn_as_point;
                all.px[i] = Vec3f(place_of(all.samples[i], all.axes[i], corners_px(mesh, triangle, raster), raster).px);
            }
        });
    return all;
}

double longest_side_px(const Raster& raster) {
    return std::max({raster.extent_px.x, raster.extent_px.y, raster.extent_px.z});
}

std::vector<std::uint32_t> seen_from_outside(const Samples& all, const Raster& raster) {
    mesh::Outside outside(raster.extent_px, std::max(longest_side_px(raster) / cells_along_extent, px_per_cell));
    for (const Vec3f& px : all.px) outside.mark(Vec3d(px));
    outside.flood();
    std::vector<std::uint32_t> kept;
    for (std::uint32_t i = 0; i < all.samples.size() && kept.size() < max_points; ++i)
        if (all.samples[i].is_outermost || outside.reaches(Vec3d(all.px[i]))) kept.push_back(i);
    return kept;
}

Vec3f normal_at(const mesh::Mesh& mesh, const mesh::Triangle& t, const Vec3d& w) {
    const Vec3d face = mesh::face_normal(mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]);
    const auto unit_or = [](const Vec3d& v, const Vec3d& otherwise) {
        const double size = glm::length(v);
        return size > 1e-6 && std::isfinite(size) ? v / size : otherwise;
    };
    const Vec3d otherwise = unit_or(face, Vec3d(0.0, 1.0, 0.0));
    if (mesh.normals.empty()) return Vec3f(otherwise);
    const Vec3d mean =
        w.x * Vec3d(mesh.normals[t[0]]) + w.y * Vec3d(mesh.normals[t[1]]) + w.z * Vec3d(mesh.normals[t[2]]);
    return Vec3f(unit_or(mean, otherwise));
}

Rgba8 color_at(const mesh::Mesh& mesh, const mesh::Triangle& t, const Vec3d& w) {
    const Vec4d sum = w.x * Vec4d(mesh.colors[t[0]]) + w.y * Vec4d(mesh.colors[t[1]]) + w.z * Vec4d(mesh.colors[t[2]]);
    return Rgba8(clamp(sum + 0.5, Vec4d(0.0), Vec4d(255.0)));
}

// The points themselves, from the mesh's own coordinates.
PointCloud points_of(const mesh::Mesh& mesh, const Samples& all, const std::vector<std::uint32_t>& kept,
                     const Raster& raster, const ResampleOptions& options) {
    PointCloud cloud;
    cloud.positions.resize(kept.size());
    cloud.normals.resize(kept.size());
    const bool has_colors = options.color || !mesh.colors.empty();
    if (has_colors) cloud.colors.resize(kept.size());
    simplify::for_each_run(options.executor, kept.size(), samples_in_run, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const Sample& sample = all.samples[kept[i]];
            const std::uint32_t triangle = sample.hit.triangle & ~drawn_as_point;
            const mesh::Triangle& t = mesh.triangles[triangle];
            const Place place = place_of(sample, all.axes[kept[i]], corners_px(mesh, triangle, raster), raster);
            const Vec3d& w = place.weights;
            const Vec3d on_surface = w.x * Vec3d(mesh.positions[t[0]]) + w.y * Vec3d(mesh.positions[t[1]]) +
                                     w.z * Vec3d(mesh.positions[t[2]]);
            cloud.positions[i] = Vec3f(sample.fills_a_hole ? raster.low + place.px / raster.px_per_unit : on_surface);
            cloud.normals[i] = normal_at(mesh, t, w);
            if (has_colors) cloud.colors[i] = options.color ? options.color(triangle, Vec3f(w)) : color_at(mesh, t, w);
        }
    });
    return cloud;
}

PointCloud points_of(const mesh::Mesh& mesh, Hits hits, const Raster& raster, const ResampleOptions& options) {
    const Samples samples = sample_views(mesh, std::move(hits), raster, options);
    return points_of(mesh, samples, seen_from_outside(samples, raster), raster, options);
}

// Summed over the three views, in squares of the box's longest side.
double projected_area(const mesh::Mesh& mesh, double longest) {
    double sum = 0.0;
    for (const mesh::Triangle& t : mesh.triangles) {
        const Vec3d a(mesh.positions[t[0]]);
        const Vec3d n = cross((Vec3d(mesh.positions[t[1]]) - a) / longest, (Vec3d(mesh.positions[t[2]]) - a) / longest);
        sum += 0.5 * (std::abs(n.x) + std::abs(n.y) + std::abs(n.z));
    }
    return sum;
}

}  // namespace

Parameters choose_parameters(const mesh::Mesh& mesh, std::uint64_t budget, std::uint32_t pixels) {
    const double longest = longest_side(mesh::bounds(mesh));
    if (!(longest > 0.0) || budget == 0) return {};
    const double wanted = oversampling * static_cast<double>(std::min(budget, max_points));
    const double area = projected_area(mesh, longest);
    double side = area > 0.0 ? std::sqrt(wanted / area) : wanted;
    if (pixels > 0) side = std::min(side, samples_per_pixel * pixels);
    const auto whole = static_cast<std::uint32_t>(std::clamp(std::ceil(side), 1.0, static_cast<double>(max_side)));
    return {std::min(whole, max_slices), whole};
}

PointCloud resample(const mesh::Mesh& mesh, const Parameters& parameters, const ResampleOptions& options) {
    if (mesh.triangles.empty()) return {};
    const Raster raster = raster_of(mesh::bounds(mesh), parameters);
    return points_of(mesh, draw_all(mesh, raster, options.executor), raster, options);
}

Result<PointCloud> resample(const mesh::Mesh& mesh, const Parameters& parameters, const DrawSlices& draw,
                            const ResampleOptions& options) {
    if (mesh.triangles.empty()) return PointCloud{};
    const Raster raster = raster_of(mesh::bounds(mesh), parameters);
    auto hits = draw_all(mesh, raster, draw);
    if (!hits) return hits.error();
    return points_of(mesh, *std::move(hits), raster, options);
}

}  // namespace lodestream::points
