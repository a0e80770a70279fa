#include "client/roam/tour.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/shading/view.h"

namespace lodestream::roam {

namespace {

struct Station {
    Vec3d eye, target;
};

// The mean of a and b in time and space that comes to rest at both.
Station between(const Station& a, const Station& b, double t) {
    const double smooth = t * t * (3.0 - 2.0 * t);
    return {a.eye + smooth * (b.eye - a.eye), a.target + smooth * (b.target - a.target)};
}

}  // namespace

motion::Trace tour(const Box& bounds) {
    if (bounds.empty() || !(bounds.radius() > 0.0)) return {{0.0, {}}};
    const Vec3d center = bounds.center(), half = bounds.extent() / 2.0;
    const bool along_x = half.x >= half.z;
    const Vec3d along = along_x ? Vec3d{half.x, 0.0, 0.0} : Vec3d{0.0, 0.0, half.z};
    const Vec3d aside = along_x ? Vec3d{0.0, 0.0, half.z} : Vec3d{half.x, 0.0, 0.0};
    const Vec3d beside = center + aside + 0.25 * bounds.radius() * Vec3d{along_x ? 0.0 : 1.0, 0.5, along_x ? 1.0 : 0.0};
    const shading::View home = shading::framing_view(bounds);
    // Close up it looks ahead along the side, a little inwards.
    const std::array<Station, 4> stations{{{home.eye, home.target},
                                           {beside - 0.9 * along, center - 0.3 * along},
                                           {beside + 0.7 * along, center + 1.3 * along},
                                           {center + along + 3.0 * (home.eye - home.target), center}}};
    const int samples = static_cast<int>(std::lround(tour_s / motion::sample_interval_s));
    motion::Trace trace;
    for (int i = 0; i <= samples; ++i) {
        const double at = static_cast<double>(stations.size() - 1) * i / samples;
        const auto leg = std::min(static_cast<std::size_t>(at), stations.size() - 2);
        const Station now = between(stations[leg], stations[leg + 1], at - static_cast<double>(leg));
        trace.push_back({tour_s * i / samples, motion::looking_at(now.eye, now.target)});
    }
    return trace;
}

}  // namespace lodestream::roam
