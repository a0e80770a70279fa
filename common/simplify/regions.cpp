#include "common/simplify/regions.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace lodestream::simplify {

namespace {

constexpr std::size_t sampled_per_region = 256;  // of its positions, to place the planes by
constexpr double turn_per_round = 0.6;           // radians, of the planes
constexpr std::size_t positions_per_task = 1u << 15;
// How far the positions reach along an axis is judged without this share at either end: one may be far away.
constexpr double spread_tail = 0.1;

// The axes turned around the first octant's middle.
std::array<Vec3d, 3> axes_of(std::size_t round) {
    const double angle = turn_per_round * static_cast<double>(round), c = std::cos(angle), s = std::sin(angle);
    const double same = (1 + 2 * c) / 3, next = (1 - c) / 3 + s / std::sqrt(3.0),
                 last = (1 - c) / 3 - s / std::sqrt(3.0);
    return {Vec3d{same, next, last}, Vec3d{last, same, next}, Vec3d{next, last, same}};
}

class Planes {
  public:
    Planes(std::vector<Vec3f> sample, std::size_t count, std::size_t round)
        : axes_(axes_of(round)), sample_(std::move(sample)) {
        part(0, sample_.size(), 0, static_cast<std::uint16_t>(count));
    }

    std::uint16_t region_of(const Vec3f& point) const {
        std::size_t node = 0;
        while (nodes_[node].above != 0)
            node = dot(axes_[nodes_[node].axis], Vec3d(point)) < nodes_[node].at ? node + 1 : nodes_[node].above;
        return nodes_[node].region;
    }

  private:
    struct Node {  // its lower child is the next one
        std::uint32_t axis = 0;
        double at = 0.0;
        std::size_t above = 0;  // the upper child; 0: none, a region
        std::uint16_t region = 0;
    };

    // The value that the share of the sample's run has less than.
    double quantile(std::size_t begin, std::size_t end, std::size_t axis, double share) {
        const auto at = [&](std::size_t i) { return sample_.begin() + static_cast<std::ptrdiff_t>(i); };
        const auto middle = at(begin + static_cast<std::size_t>(share * static_cast<double>(end - begin - 1)));
        const auto along = [&](const Vec3f& p) { return dot(axes_[axis], Vec3d(p)); };
        std::nth_element(at(begin), middle, at(end),
                         [&](const Vec3f& a, const Vec3f& b) { return along(a) < along(b); });
        return along(*middle);
    }

    void part(std::size_t begin, std::size_t end, std::uint16_t first, std::uint16_t count) {
        const std::size_t number = nodes_.size();
        nodes_.push_back({.region = first});
        if (count == 1 || begin == end) return;
        std::array<double, 3> spread{};
        for (std::size_t k = 0; k < 3; ++k)
            spread[k] = quantile(begin, end, k, 1 - spread_tail) - quantile(begin, end, k, spread_tail);
        const auto widest = static_cast<std::size_t>(std::max_element(spread.begin(), spread.end()) - spread.begin());
        const auto below = static_cast<std::uint16_t>(count / 2);
        const double share = static_cast<double>(below) / count;
        nodes_[number].axis = static_cast<std::uint32_t>(widest);
        nodes_[number].at = quantile(begin, end, widest, share);
        const std::size_t middle = begin + static_cast<std::size_t>(share * static_cast<double>(end - begin));
        part(begin, middle, first, below);
        nodes_[number].above = nodes_.size();
        part(middle, end, static_cast<std::uint16_t>(first + below), static_cast<std::uint16_t>(count - below));
    }

    const std::array<Vec3d, 3> axes_;
    std::vector<Vec3f> sample_;
    std::vector<Node> nodes_;
};

}  // namespace

Regions divide(const std::vector<std::uint32_t>& positions, const std::vector<Vec3f>& points, std::size_t count,
               std::size_t round, const Executor& executor) {
    std::vector<Vec3f> sample;
    const std::size_t step = std::max<std::size_t>(1, positions.size() / (sampled_per_region * count));
    for (std::size_t i = 0; i < positions.size(); i += step) sample.push_back(points[positions[i]]);
    const Planes planes(std::move(sample), count, round);

    Regions regions;
    regions.of.resize(points.size());
    for_each_run(executor, positions.size(), positions_per_task, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) regions.of[positions[i]] = planes.region_of(points[positions[i]]);
    });
    std::vector<std::size_t> next(count + 1, 0);
    for (const std::uint32_t p : positions) ++next[regions.of[p] + 1u];
    for (std::size_t r = 0; r < count; ++r) next[r + 1] += next[r];
    regions.first = next;
    regions.positions.resize(positions.size());
    for (const std::uint32_t p : positions) regions.positions[next[regions.of[p]]++] = p;
    return regions;
}

}  // namespace lodestream::simplify
