#include "common/points/view.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

namespace lodestream::points {

namespace {

// Hits by pixel.
struct Layers {
    std::vector<Hit> hits;             // by pixel, then by depth
    std::vector<std::uint32_t> first;  // of each pixel, and one past the last

    std::span<const Hit> at(std::size_t pixel) const {
        return std::span(hits).subspan(first[pixel], first[pixel + 1] - first[pixel]);
    }
};

Layers layers_of(std::vector<Hit> hits, const ViewSize& size) {
    Layers layers;
    layers.first.assign(std::size_t{size.width} * size.height + 1, 0);
    for (const Hit& hit : hits) ++layers.first[hit.pixel + 1];
    std::partial_sum(layers.first.begin(), layers.first.end(), layers.first.begin());
    layers.hits.resize(hits.size());
    std::vector<std::uint32_t> next(layers.first.begin(), layers.first.end() - 1);
    for (const Hit& hit : hits) layers.hits[next[hit.pixel]++] = hit;
    for (std::size_t pixel = 0; pixel + 1 < layers.first.size(); ++pixel) {
        const auto begin = layers.hits.begin() + layers.first[pixel],
                   end = layers.hits.begin() + layers.first[pixel + 1];
        if (end - begin > 1)
            std::sort(begin, end, [](const Hit& a, const Hit& b) {
                return a.depth != b.depth ? a.depth < b.depth : a.triangle < b.triangle;
            });
    }
    return layers;
}

// The far end of the extent belongs to the last slice.
std::uint32_t slice_of(const Hit& hit, const ViewSize& size) {
    return static_cast<std::uint32_t>(std::clamp(hit.depth / size.slice_px, 0.0, size.slices - 1.0));
}

// Of each slice what is nearest to either end of the axis.
void add_slices(std::span<const Hit> column, const ViewSize& size, std::vector<Sample>& samples) {
    for (std::size_t i = 0; i < column.size(); ++i) {
        const bool first = i == 0, last = i + 1 == column.size();
        const std::uint32_t slice = slice_of(column[i], size);
        const bool seen_from_front = first || slice_of(column[i - 1], size) != slice;
        const bool seen_from_back = last || slice_of(column[i + 1], size) != slice;
        if (seen_from_front || seen_from_back) samples.push_back({column[i], first || last, false});
    }
}

// The first of the nearest ones. A column may have thousands of hits: it is in the order of their depths.
const Hit* nearest_in(std::span<const Hit> column, float depth, double within) {
    const auto first_from = [&](float least) {
        return std::lower_bound(column.begin(), column.end(), least, [](const Hit& h, float d) { return h.depth < d; });
    };
    const auto behind = first_from(depth);
    auto best = behind;
    if (behind != column.begin()) {
        const float before = (behind - 1)->depth;
        if (behind == column.end() || depth - before <= behind->depth - depth) best = first_from(before);
    }
    return best != column.end() && std::abs(best->depth - depth) <= within ? &*best : nullptr;
}

// The neighbours of one pixel, those on opposite sides after each other: beside it first, then across its corners.
constexpr std::uint32_t back = ~0u;  // one less, as unsigned numbers wrap
constexpr std::array<std::array<std::uint32_t, 2>, 8> neighbours{
    {{back, 0}, {1, 0}, {0, back}, {0, 1}, {back, back}, {1, 1}, {1, back}, {back, 1}}};
constexpr std::size_t beside = 4;

// What the neighbours show around a depth; null where one shows nothing.
using Votes = std::array<const Hit*, neighbours.size()>;

struct Filling {
    const Hit* like = nullptr;  // null: no hole
    float depth = 0.0f;
};

Filling by_median(const Votes& votes) {
    constexpr std::ptrdiff_t least_votes = 5;
    Votes cast = votes;
    const auto end = std::remove(cast.begin(), cast.end(), nullptr);
    if (end - cast.begin() < least_votes) return {};
    const auto middle = cast.begin() + (end - cast.begin()) / 2;
    std::nth_element(cast.begin(), middle, end, [](const Hit* a, const Hit* b) { return a->depth < b->depth; });
    return {*middle, (*middle)->depth};
}

Filling by_gaussian(const Votes& votes) {
    constexpr int least_weight = 8;  // of the kernel's 16
    int weight = 0;
    double depth_sum = 0.0;
    const Hit* first = nullptr;
    for (std::size_t k = 0; k < votes.size(); ++k) {
        if (!votes[k]) continue;
        const int own = k < beside ? 2 : 1;
        weight += own;
        depth_sum += own * static_cast<double>(votes[k]->depth);
        if (!first) first = votes[k];
    }
    if (weight < least_weight) return {};
    return {first, static_cast<float>(depth_sum / weight)};
}

Filling by_opposites(const Votes& votes) {
    for (std::size_t k = 0; k < votes.size(); k += 2)
        if (votes[k] && votes[k + 1]) return {votes[k], 0.5f * (votes[k]->depth + votes[k + 1]->depth)};
    return {};
}

Filling filling_of(const Votes& votes, HoleFilter filter) {
    switch (filter) {
        case HoleFilter::none:
            return {};
        case HoleFilter::median:
            return by_median(votes);
        case HoleFilter::gaussian:
            return by_gaussian(votes);
        case HoleFilter::opposites:
            return by_opposites(votes);
    }
    return {};
}

void close_holes(const Layers& layers, const ViewSize& size, std::uint32_t x, std::uint32_t y, HoleFilter filter,
                 std::vector<Sample>& samples) {
    std::array<std::span<const Hit>, 8> columns;
    for (std::size_t k = 0; k < columns.size(); ++k) {
        const std::uint32_t row = y + neighbours[k][1], column = x + neighbours[k][0];
        columns[k] = layers.at(std::size_t{row} * size.width + column);
    }
    const std::uint32_t pixel = y * size.width + x;
    const std::span<const Hit> here = layers.at(pixel);
    std::vector<Hit> filled;
    for (std::size_t k = 0; k < beside; ++k)
        for (const Hit& seed : columns[k]) {
            const auto is_near = [&](const Hit& hit) { return std::abs(hit.depth - seed.depth) <= size.slice_px; };
            if (nearest_in(here, seed.depth, size.slice_px) || std::any_of(filled.begin(), filled.end(), is_near))
                continue;
            Votes votes;
            std::ranges::transform(columns, votes.begin(), [&](const std::span<const Hit>& column) {
                return nearest_in(column, seed.depth, size.slice_px);
            });
            const Filling filling = filling_of(votes, filter);
            if (filling.like) filled.push_back({pixel, filling.depth, filling.like->triangle});
        }
    for (const Hit& hit : filled) samples.push_back({hit, false, true});
}

}  // namespace

bool weights_at(const std::array<Vec3d, 3>& corners, double x, double y, Vec3d& weights) {
    constexpr double edge_on = 1e-9;  // px² of area: a depth found there would be rounding alone
    const Vec3d &a = corners[0], &b = corners[1], &c = corners[2];
    const double area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
    if (!(std::abs(area) > edge_on)) return false;
    const double wb = ((x - a.x) * (c.y - a.y) - (c.x - a.x) * (y - a.y)) / area;
    const double wc = ((b.x - a.x) * (y - a.y) - (x - a.x) * (b.y - a.y)) / area;
    weights = max(Vec3d(1.0 - wb - wc, wb, wc), Vec3d(0.0));
    weights /= weights.x + weights.y + weights.z;
    return true;
}

std::vector<Sample> sampled(std::vector<Hit> hits, const ViewSize& size, HoleFilter filter) {
    const Layers layers = layers_of(std::move(hits), size);
    std::vector<Sample> samples;
    samples.reserve(layers.hits.size());
    for (std::uint32_t y = 0; y < size.height; ++y)
        for (std::uint32_t x = 0; x < size.width; ++x) {
            add_slices(layers.at(std::size_t{y} * size.width + x), size, samples);
            const bool has_neighbours = x > 0 && y > 0 && x + 1 < size.width && y + 1 < size.height;
            if (filter != HoleFilter::none && has_neighbours) close_holes(layers, size, x, y, filter, samples);
        }
    return samples;
}

}  // namespace lodestream::points
