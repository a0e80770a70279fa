#include "server/importer/polygon.h"

#include <algorithm>

namespace lodestream::importer {
namespace {

using Vec2d = glm::dvec2;

double cross2(const Vec2d& a, const Vec2d& b, const Vec2d& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// The corners on the plane of the average (Newell) normal, counter-clockwise, scaled to about unit size.
std::vector<Vec2d> flattened(std::span<const Vec3d> corners) {
    Box box;
    for (const Vec3d& p : corners) box.add(p);
    const Vec3d extent = box.extent();
    const double size = std::max({extent.x, extent.y, extent.z});
    const double scale = size > 0 ? 1 / size : 0;
    const auto local = [&](std::size_t i) { return (corners[i] - box.min) * scale; };

    Vec3d normal{0};
    for (std::size_t i = 0; i < corners.size(); ++i)
        normal += glm::cross(local(i), local(i + 1 < corners.size() ? i + 1 : 0));
    const Vec3d size_along = glm::abs(normal);
    int drop = 0;
    if (size_along.y > size_along[drop]) drop = 1;
    if (size_along.z > size_along[drop]) drop = 2;
    const int u = (drop + 1) % 3, v = (drop + 2) % 3;

    std::vector<Vec2d> flat(corners.size());
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const Vec3d p = local(i);
        flat[i] = normal[drop] >= 0 ? Vec2d{p[u], p[v]} : Vec2d{p[v], p[u]};
    }
    return flat;
}

bool inside(const Vec2d& p, const Vec2d& a, const Vec2d& b, const Vec2d& c) {
    if (p == a || p == b || p == c) return false;  // outlines that touch themselves, as around a bridged hole
    return cross2(a, b, p) >= 0 && cross2(b, c, p) >= 0 && cross2(c, a, p) >= 0;
}

class EarClipper {
  public:
    EarClipper(std::span<const Vec3d> corners, std::uint64_t& work, std::uint64_t max_work)
        : flat_(flattened(corners)),
          next_(corners.size()),
          previous_(corners.size()),
          work_(work),
          max_work_(max_work) {
        const auto n = static_cast<std::uint32_t>(corners.size());
        for (std::uint32_t i = 0; i < n; ++i) {
            next_[i] = i + 1 < n ? i + 1 : 0;
            previous_[i] = i > 0 ? i - 1 : n - 1;
        }
        for (std::uint32_t i = 0; i < n; ++i)
            if (turn(i) < 0) reflex_.push_back(i);
    }

    void clip(std::vector<mesh::Triangle>& out) {
        std::uint32_t at = 0;
        for (std::size_t left = flat_.size(); left > 3; --left) {
            at = find_ear(at, left);
            out.push_back({previous_[at], at, next_[at]});
            next_[previous_[at]] = next_[at];
            previous_[next_[at]] = previous_[at];
            forget_convex(at, previous_[at], next_[at]);
            at = next_[next_[at]];  // skipping one spreads the ears round the outline instead of fanning
        }
        out.push_back({previous_[at], at, next_[at]});
    }

  private:
    double turn(std::uint32_t i) const { return cross2(flat_[previous_[i]], flat_[i], flat_[next_[i]]); }

    bool is_ear(std::uint32_t i) {
        if (turn(i) <= 0) return false;
        const std::uint32_t before = previous_[i], after = next_[i];
        work_ += reflex_.size();
        return std::none_of(reflex_.begin(), reflex_.end(), [&](std::uint32_t r) {
            return r != before && r != after && r != i && inside(flat_[r], flat_[before], flat_[i], flat_[after]);
        });
    }

    // Where no corner is an ear (a self-crossing or flat outline), any convex corner, else the one asked for.
    std::uint32_t find_ear(std::uint32_t from, std::size_t left) {
        if (work_ > max_work_) return from;
        std::uint32_t convex = from, at = from;
        for (std::size_t i = 0; i < left; ++i, at = next_[at]) {
            ++work_;
            if (is_ear(at)) return at;
            if (turn(convex) <= 0 && turn(at) > 0) convex = at;
        }
        return convex;
    }

    void forget_convex(std::uint32_t gone, std::uint32_t before, std::uint32_t after) {
        work_ += reflex_.size();
        std::erase_if(reflex_,
                      [&](std::uint32_t r) { return r == gone || ((r == before || r == after) && turn(r) >= 0); });
    }

    std::vector<Vec2d> flat_;
    std::vector<std::uint32_t> next_, previous_, reflex_;
    std::uint64_t& work_;
    std::uint64_t max_work_;
};

// The diagonal that leaves both halves facing the same way; of two such the shorter.
void cut_quad(std::span<const Vec3d> p, std::vector<mesh::Triangle>& out) {
    const std::vector<Vec2d> f = flattened(p);
    const double across_02 = std::min(cross2(f[0], f[1], f[2]), cross2(f[0], f[2], f[3]));
    const double across_13 = std::min(cross2(f[0], f[1], f[3]), cross2(f[1], f[2], f[3]));
    const bool both = across_02 > 0 && across_13 > 0;
    const bool use_02 = both ? glm::distance(p[0], p[2]) <= glm::distance(p[1], p[3]) : across_02 >= across_13;
    if (use_02) {
        out.push_back({0, 1, 2});
        out.push_back({0, 2, 3});
    } else {
        out.push_back({0, 1, 3});
        out.push_back({1, 2, 3});
    }
}

}  // namespace

void triangulate(std::span<const Vec3d> corners, std::vector<mesh::Triangle>& out, std::uint64_t& work,
                 std::uint64_t max_work) {
    if (corners.size() == 3)
        out.push_back({0, 1, 2});
    else if (corners.size() == 4)
        cut_quad(corners, out);
    else
        EarClipper(corners, work, max_work).clip(out);
}

}  // namespace lodestream::importer
