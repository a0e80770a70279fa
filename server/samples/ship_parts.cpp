#include "server/samples/ship_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <vector>

namespace lodestream::samples {
namespace {

void use(ShapeBuilder& builder, Paint paint) {
    builder.use_material(static_cast<std::uint32_t>(paint));
}

void lathe(ShapeBuilder& builder, const Frame& frame, std::initializer_list<Vec2d> profile, int sides) {
    builder.lathe(frame, std::span(profile.begin(), profile.size()), sides);
}

double ramp(double from, double to, double t) {
    return std::clamp((t - from) / (to - from), 0.0, 1.0);
}

// The hull's shape: half the breadth at the waterline, the depth of the keel and the fullness of the section.

double waterline_half_beam(const ShipPlan& plan, double t) {
    const double entrance = 1 - std::pow(ramp(0.76, 1.0, t), 1.8),
                 run = 1 - 0.75 * std::pow(1 - ramp(0.0, 0.24, t), 2.0);
    return 0.5 * plan.beam * entrance * run;
}

double keel_y(const ShipPlan& plan, double t) {
    return -plan.draft * (1 - 0.9 * std::pow(1 - ramp(0.0, 0.13, t), 2.2));
}

double fullness(double t) {
    return 1.5 + 5.0 * ramp(0.04, 0.3, t) * (1 - ramp(0.72, 0.98, t));
}

double stem_overhang(const ShipPlan& plan, double t, double y) {
    const double above = std::clamp(y / (plan.freeboard * 1.4), -0.3, 1.0);
    return 0.045 * plan.length * above * std::pow(t, 12.0);
}

constexpr int hull_stations = 72;
constexpr int hull_bottom_rows = 14;
constexpr int hull_side_rows = 8;

// Stations are closer at the ends, where the hull bends.
double station(int i) {
    const double s = static_cast<double>(i) / hull_stations;
    return 0.35 * s + 0.65 * (0.5 - 0.5 * std::cos(pi * s));
}

Vec3d bottom_point(const ShipPlan& plan, double t, double q) {
    const double p = fullness(t), y = keel_y(plan, t) * (1 - q);
    const double z = waterline_half_beam(plan, t) * std::pow(1 - std::pow(1 - q, p), 1 / p);
    return {plan.x(t) + stem_overhang(plan, t, y), y, z};
}

Vec3d side_point(const ShipPlan& plan, double t, double q) {
    const double y = plan.deck_y(t) * q;
    const double z = std::lerp(waterline_half_beam(plan, t), plan.deck_half_beam(t), std::pow(q, 1.4));
    return {plan.x(t) + stem_overhang(plan, t, y), y, z};
}

std::vector<std::vector<Vec3d>> mirrored(std::vector<std::vector<Vec3d>> rows) {
    for (auto& row : rows)
        for (Vec3d& p : row) p.z = -p.z;
    std::reverse(rows.begin(), rows.end());
    return rows;
}

struct HullSide {
    std::vector<std::vector<Vec3d>> bottom, side;  // starboard, a row a station from the stern
};

HullSide starboard(const ShipPlan& plan) {
    HullSide hull;
    for (int i = 0; i <= hull_stations; ++i) {
        const double t = station(i);
        std::vector<Vec3d> bottom, side;
        for (int j = 0; j <= hull_bottom_rows; ++j)
            bottom.push_back(bottom_point(plan, t, std::pow(static_cast<double>(j) / hull_bottom_rows, 2.5)));
        for (int j = 0; j <= hull_side_rows; ++j)
            side.push_back(side_point(plan, t, static_cast<double>(j) / hull_side_rows));
        hull.bottom.push_back(std::move(bottom));
        hull.side.push_back(std::move(side));
    }
    return hull;
}

std::vector<Vec3d> mirrored(std::vector<Vec3d> chain) {
    for (Vec3d& p : chain) p.z = -p.z;
    return chain;
}

// A box whose four upright edges are cut off.
void chamfered(ShapeBuilder& builder, const Frame& frame, double length, double width, double height, double cut) {
    const double x = length / 2, z = width / 2;
    const std::array<Vec2d, 4> left{{{-x, cut - z}, {cut - x, -z}, {x - cut, -z}, {x, cut - z}}};
    const std::array<Vec2d, 4> right{{{-x, z - cut}, {cut - x, z}, {x - cut, z}, {x, z - cut}}};
    builder.prism(frame, left, right, height);
}

// Diagonals and chords of a crane's jib, square in section.
void lattice(ShapeBuilder& builder, const Vec3d& from, const Vec3d& to, double side, int panels) {
    const Frame frame = along(from, to);
    const double size = length(to - from), h = side / 2;
    const std::array<Vec2d, 4> corners{{{-h, -h}, {h, -h}, {h, h}, {-h, h}}};
    for (std::size_t k = 0; k < corners.size(); ++k) {
        const Vec2d a = corners[k], b = corners[(k + 1) % corners.size()];
        builder.rod(frame.point({a.x, 0, a.y}), frame.point({a.x, size, a.y}), 0.09 * side, 6);
        for (int i = 0; i < panels; ++i) {
            const double low = size * i / panels, high = size * (i + 1) / panels;
            builder.rod(frame.point({a.x, low, a.y}), frame.point({b.x, high, b.y}), 0.05 * side, 4);
        }
    }
}

}  // namespace

double ShipPlan::deck_y(double t) const {
    return freeboard * (1 + 0.35 * std::pow(ramp(0.72, 1.0, t), 2.0) + 0.06 * std::pow(1 - ramp(0.0, 0.15, t), 2.0));
}

double ShipPlan::deck_half_beam(double t) const {
    return 0.5 * beam * (1 - std::pow(ramp(0.84, 1.0, t), 2.4)) * (1 - 0.22 * std::pow(1 - ramp(0.0, 0.14, t), 2.0));
}

Frame on_deck(const ShipPlan& plan, double t, int side, double inset_m) {
    const double y = plan.deck_y(t), z = std::max(0.2, plan.deck_half_beam(t) - inset_m);
    return turned_at({plan.x(t) + stem_overhang(plan, t, y), y, side * z}, side > 0 ? 0 : pi);
}

Frame container_place(const ShipPlan& plan, int bay, int row, int tier) {
    const double z = (row - 0.5 * (plan.rows - 1)) * ShipPlan::row_pitch_m;
    return {{plan.bay_x(bay), plan.stack_y() + tier * ShipPlan::container_height_m, z}};
}

Frame window_place(const ShipPlan& plan, double position, int level, bool aft) {
    const double shrink = 1 - 0.02 * level, facing = aft ? -1 : 1;
    return {{plan.house_x() + facing * 0.5 * plan.house_length() * shrink,
             plan.deck_y(0.11) + (level + 0.55) * ShipPlan::level_height_m,
             (position - 0.5) * (plan.house_width() - 2.4) * shrink}};
}

Frame ladder_place(const ShipPlan& plan, int level, int side, double position) {
    const double shrink = 1 - 0.02 * level;
    return turned_at(
        {plan.house_x() + (position - 0.5) * 0.7 * plan.house_length(),
         plan.deck_y(0.11) + level * ShipPlan::level_height_m, side * (0.5 * plan.house_width() * shrink + 0.25)},
        0);
}

void add_hull(ShapeBuilder& builder, const ShipPlan& plan) {
    const HullSide hull = starboard(plan);
    use(builder, Paint::antifouling);
    builder.sheet(hull.bottom);
    builder.sheet(mirrored(hull.bottom));
    use(builder, Paint::hull);
    builder.sheet(hull.side);
    builder.sheet(mirrored(hull.side));
    builder.ladder(hull.bottom.front(), mirrored(hull.bottom.front()));
    builder.ladder(hull.side.front(), mirrored(hull.side.front()));

    use(builder, Paint::deck);
    std::vector<Vec3d> edge;
    for (const auto& row : hull.side) edge.push_back(row.back());
    builder.ladder(edge, mirrored(edge));
}

void add_house_level(ShapeBuilder& builder, const ShipPlan& plan, int level) {
    const double y = plan.deck_y(0.11) + level * ShipPlan::level_height_m;
    const double shrink = 0.02 * level;
    use(builder, Paint::white);
    const double inside = ShipPlan::level_height_m - 0.2;
    chamfered(builder, {{plan.house_x(), y, 0}}, plan.house_length() * (1 - shrink), plan.house_width() * (1 - shrink),
              inside, 0.6);
    use(builder, Paint::deck);
    chamfered(builder, {{plan.house_x(), y + inside, 0}}, plan.house_length() * (1 - shrink) + 1.2,
              plan.house_width() * (1 - shrink) + 1.2, 0.2, 0.8);
}

void add_bridge(ShapeBuilder& builder, const ShipPlan& plan) {
    const Frame frame{{plan.house_x() + 0.1 * plan.house_length(), plan.house_top(), 0}};
    const double length = 0.6 * plan.house_length(), width = 0.62 * plan.house_width();
    use(builder, Paint::white);
    chamfered(builder, frame, length, width, 1.1, 0.8);
    builder.box(moved(frame, {0, 0.55, 0}), {0.5 * length, 1.1, plan.beam});  // the wings
    use(builder, Paint::glass);
    chamfered(builder, moved(frame, {0, 1.1, 0}), length - 0.2, width - 0.2, 1.0, 0.8);
    use(builder, Paint::white);
    chamfered(builder, moved(frame, {0, 2.1, 0}), length + 0.6, width + 0.6, 0.5, 0.9);
}

void add_funnel(ShapeBuilder& builder, const ShipPlan& plan) {
    const double r = 0.085 * plan.beam, h = 0.32 * plan.beam;
    const Frame frame{{plan.house_x() - 0.5 * plan.house_length() - 1.6 * r, plan.deck_y(0.06), 0}, {1.5, 0, 0}};
    const double base = 0.62 * (plan.house_top() - plan.deck_y(0.11));
    use(builder, Paint::white);
    chamfered(builder, {frame.origin}, 4.2 * r, 3.6 * r, base, 0.4 * r);
    use(builder, Paint::blue);
    lathe(builder, moved(frame, {0, base, 0}), {{r, 0}, {r, 0.5 * h}}, 24);
    use(builder, Paint::yellow);
    lathe(builder, moved(frame, {0, base, 0}), {{r, 0.5 * h}, {r, 0.75 * h}}, 24);
    use(builder, Paint::steel);
    lathe(builder, moved(frame, {0, base, 0}),
          {{r, 0.75 * h}, {0.95 * r, h}, {0.8 * r, h}, {0.75 * r, 0.9 * h}, {0, 0.9 * h}}, 24);
    for (const double z : {-0.3, 0.0, 0.3})
        builder.rod(frame.point({0, base + 0.8 * h, z * r}), frame.point({-0.1 * r, base + 1.15 * h, z * r}), 0.12 * r,
                    10);
}

void add_forecastle(ShapeBuilder& builder, const ShipPlan& plan) {
    constexpr int steps = 12;
    const double height = 0.12 * plan.freeboard + 0.6;
    for (const int side : {1, -1}) {
        std::vector<Vec3d> outer, inner, outer_top, inner_top;
        for (int i = 0; i <= steps; ++i) {
            const double t = std::lerp(0.9, 0.985, static_cast<double>(side > 0 ? i : steps - i) / steps);
            outer.push_back(on_deck(plan, t, side, 0.1).origin);
            inner.push_back(on_deck(plan, t, side, 0.35).origin);
            outer_top.push_back(outer.back() + Vec3d{0, height, 0});
            inner_top.push_back(inner.back() + Vec3d{0, height, 0});
        }
        use(builder, Paint::hull);
        builder.ladder(outer, outer_top);
        use(builder, Paint::white);
        builder.ladder(inner_top, inner);
        builder.ladder(outer_top, inner_top);
        builder.ladder(std::array{inner.front(), outer.front()}, std::array{inner_top.front(), outer_top.front()});
        builder.ladder(std::array{outer.back(), inner.back()}, std::array{outer_top.back(), inner_top.back()});
    }
}

void add_foremast(ShapeBuilder& builder, const ShipPlan& plan) {
    const double t = 0.94, y = plan.deck_y(t), h = 0.1 * plan.length;
    const Frame frame{{plan.x(t), y, 0}};
    use(builder, Paint::white);
    lathe(builder, frame, {{0.05 * h, 0}, {0.03 * h, 0.1 * h}, {0.012 * h, h}, {0, h}}, 14);
    builder.rod(frame.point({0, 0.75 * h, -0.18 * h}), frame.point({0, 0.75 * h, 0.18 * h}), 0.008 * h, 8);
    builder.rod(frame.point({-0.35 * h, 0, 0}), frame.point({0, 0.7 * h, 0}), 0.012 * h, 8);
    use(builder, Paint::yellow);
    for (const double level : {0.6, 0.9})
        lathe(builder, moved(frame, {0.03 * h, level * h, 0}),
              {{0, -0.02 * h}, {0.02 * h, -0.02 * h}, {0.02 * h, 0.02 * h}, {0, 0.02 * h}}, 10);
}

void add_bulb(ShapeBuilder& builder, const ShipPlan& plan) {
    constexpr int steps = 12;
    std::vector<Vec2d> profile;
    const double radius = 0.24 * plan.draft, size = 0.06 * plan.length;
    for (int i = 0; i <= steps; ++i) {
        const double angle = pi * i / steps;
        profile.emplace_back(i == 0 || i == steps ? 0.0 : radius * std::sin(angle), -size * std::cos(angle));
    }
    const Vec3d middle{plan.x(0.985), -0.6 * plan.draft, 0};
    use(builder, Paint::antifouling);
    builder.lathe(along(middle, middle + Vec3d{1, 0.04, 0}), profile, 20);
}

void add_propeller(ShapeBuilder& builder, const ShipPlan& plan) {
    const double r = 0.3 * plan.draft;
    const Vec3d hub{plan.x(0.028), -0.62 * plan.draft, 0};
    use(builder, Paint::yellow);
    builder.rod(hub - Vec3d{0.3 * r, 0, 0}, {plan.x(0.09), hub.y, 0}, 0.16 * r, 14);
    for (int blade = 0; blade < 5; ++blade) {
        const double angle = 2 * pi * blade / 5;
        const Vec3d out{0, std::cos(angle), std::sin(angle)},
            side = normalize(cross(out, Vec3d{1, 0, 0}) + Vec3d{0.8, 0, 0});
        builder.box({hub + out * (0.58 * r), cross(out, side), out, side}, {0.05 * r, 0.9 * r, 0.42 * r});
    }
}

void add_rudder(ShapeBuilder& builder, const ShipPlan& plan) {
    const double chord = 0.022 * plan.length, thickness = 0.16 * chord;
    const std::array<Vec2d, 5> left{{{-chord, -0.02},
                                     {-0.4 * chord, -0.6 * thickness},
                                     {0.1 * chord, -thickness},
                                     {0.4 * chord, -0.7 * thickness},
                                     {0.55 * chord, -0.05}}};
    std::array<Vec2d, 5> right = left;
    for (Vec2d& p : right) p.y = -p.y;
    use(builder, Paint::antifouling);
    builder.prism({{plan.x(0.008), -0.98 * plan.draft, 0}}, left, right, 0.9 * plan.draft);
}

void add_crane(ShapeBuilder& builder, const ShipPlan& plan, int bay, double slew) {
    const double r = 0.045 * plan.beam + 0.3,
                 tower = plan.stack_y() + (plan.tiers + 0.5) * ShipPlan::container_height_m;
    const Vec3d foot{plan.bay_x(bay), plan.deck_y(0.5), 0};
    use(builder, Paint::yellow);
    lathe(builder, {foot},
          {{1.5 * r, 0},
           {1.5 * r, 1.2},
           {r, 1.6},
           {r, tower - foot.y},
           {1.4 * r, tower - foot.y + 0.4},
           {0, tower - foot.y + 0.4}},
          18);
    const Frame cab = turned_at({foot.x, tower + 0.4, 0}, slew);
    chamfered(builder, cab, 3.2 * r, 2.4 * r, 2.2 * r, 0.4 * r);
    const double reach = 0.75 * plan.beam;
    const Vec3d heel = cab.point({1.6 * r, 0.6 * r, 0}), tip = cab.point({1.6 * r + reach, 0.6 * r + 0.16 * reach, 0});
    lattice(builder, heel, tip, 0.9 * r, 8);
    use(builder, Paint::steel);
    const Vec3d top = cab.point({0, 4.2 * r, 0});
    builder.rod(cab.point({-0.8 * r, 2.2 * r, 0}), top, 0.2 * r, 8);
    for (const double z : {-0.3, 0.3}) builder.rod(top, tip + cab.direction({0, 0.5 * r, z * r}), 0.05, 4);
    builder.rod(tip, tip - Vec3d{0, 0.2 * plan.beam, 0}, 0.06, 4);
    lathe(builder, {tip - Vec3d{0, 0.2 * plan.beam + 0.8, 0}}, {{0, 0}, {0.35, 0.2}, {0.35, 0.7}, {0, 0.9}}, 8);
}

void add_lifeboat(ShapeBuilder& builder, const ShipPlan& plan, int side) {
    constexpr int stations = 14, around = 12;
    const double size = 0.042 * plan.length + 1.5, radius = 0.17 * size;
    const Vec3d middle{plan.house_x(), plan.deck_y(0.11) + 2 * ShipPlan::level_height_m + radius,
                       side * (0.5 * plan.house_width() + 1.3 * radius)};
    std::vector<std::vector<Vec3d>> rows;
    for (int i = 0; i <= stations; ++i) {
        const double s = std::cos(pi * i / stations), r = radius * std::sqrt(std::max(0.0, 1 - s * s * s * s));
        std::vector<Vec3d> row;
        for (int j = 0; j <= around; ++j) {
            const double angle = 2 * pi * (j == around ? 0 : j) / around;
            row.push_back(middle + Vec3d{-0.5 * size * s, r * std::sin(angle) * (std::sin(angle) < 0 ? 1.15 : 0.85),
                                         r * std::cos(angle)});
        }
        rows.push_back(std::move(row));
    }
    use(builder, Paint::orange);
    builder.sheet(rows);
    use(builder, Paint::white);
    const double inboard = side * 0.5 * plan.house_width() * 0.96;
    for (const double x : {-0.33, 0.33}) {
        const Vec3d foot{middle.x + x * size, middle.y - 1.6 * radius, inboard};
        const Vec3d bend{foot.x, middle.y + 2.2 * radius, inboard + side * 0.4 * radius};
        const Vec3d head{foot.x, middle.y + 2.0 * radius, middle.z};
        builder.rod(foot, bend, 0.12 * radius, 8);
        builder.rod(bend, head, 0.12 * radius, 8);
        builder.rod(head, {foot.x, middle.y + 0.7 * radius, middle.z}, 0.04 * radius, 4);
    }
}

void add_anchor(ShapeBuilder& builder, const ShipPlan& plan, int side) {
    const Vec3d at = side_point(plan, 0.955, 0.62);
    const Vec3d top{at.x, at.y, side * (at.z + 0.15)};
    const double size = 0.18 * plan.freeboard;
    use(builder, Paint::steel);
    builder.rod(top, top - Vec3d{0, size, 0}, 0.08 * size, 8);
    for (const double x : {-1.0, 1.0})
        builder.rod(top - Vec3d{0, size, 0}, top + Vec3d{0.4 * x * size, -0.55 * size, side * 0.1 * size}, 0.1 * size,
                    6);
    lathe(builder, along(top - Vec3d{0, 0, side * 0.5}, top + Vec3d{0, 0, side * 0.5}),
          {{0, 0}, {0.25 * size, 0}, {0.25 * size, 0.6}, {0, 0.6}}, 14);
}

void add_winch(ShapeBuilder& builder, const Frame& frame) {
    use(builder, Paint::steel);
    builder.box(moved(frame, {0, 0.15, 0}), {2.2, 0.3, 1.6});
    const Frame drum = along(frame.point({0, 0.9, -0.9}), frame.point({0, 0.9, 0.9}));
    lathe(builder, drum, {{0, 0}, {0.7, 0}, {0.7, 0.15}, {0.4, 0.15}, {0.4, 1.65}, {0.7, 1.65}, {0.7, 1.8}, {0, 1.8}},
          14);
    use(builder, Paint::green);
    builder.box(moved(frame, {-0.9, 0.8, 0}), {0.6, 1.0, 0.9});
}

void add_radar(ShapeBuilder& builder, const ShipPlan& plan, int which, double bearing) {
    const double h = 3.0 + 2.0 * which;
    const Frame frame =
        turned_at({plan.house_x() + 0.1 * plan.house_length() + 1.2 * which, plan.house_top() + 2.6, 0}, bearing);
    use(builder, Paint::white);
    lathe(builder, frame, {{0.35, 0}, {0.15, h}, {0, h}}, 10);
    builder.box(moved(frame, {0, h + 0.15, 0}), {0.5, 0.3, 0.5});
    builder.box(moved(frame, {0, h + 0.45, 0}), {0.25, 0.3, 3.0});
}

void add_radome(ShapeBuilder& builder, const ShipPlan& plan, int side) {
    constexpr int steps = 8;
    const double r = 0.9;
    std::vector<Vec2d> profile{{0.25, 0.0}, {0.25, 1.0}};
    for (int i = 1; i <= steps; ++i) {
        const double angle = pi * i / steps;
        profile.emplace_back(i == steps ? 0.0 : r * std::sin(angle), 1.0 + r - r * std::cos(angle));
    }
    use(builder, Paint::white);
    builder.lathe({{plan.house_x() - 0.1 * plan.house_length(), plan.house_top(), side * 0.38 * plan.house_width()}},
                  profile, 16);
}

void add_hatch_cover(ShapeBuilder& builder, const ShipPlan& plan, int bay, int half) {
    const double width = 0.5 * plan.rows * ShipPlan::row_pitch_m;
    const Frame frame{{plan.bay_x(bay), plan.deck_y(0.5), (half - 0.5) * width}};
    use(builder, Paint::deck);
    builder.box(moved(frame, {0, 0.75, 0}), {ShipPlan::bay_pitch_m - 0.7, 1.5, width - 0.3});
    use(builder, Paint::red);
    builder.box(moved(frame, {0, 1.64, 0}), {ShipPlan::bay_pitch_m - 0.4, 0.28, width - 0.06});
}

void add_container(ShapeBuilder& builder, const Frame& frame, Paint paint, int waves) {
    constexpr double depth_m = 0.12, door_m = 0.35;
    const double half_length = ShipPlan::container_length_m / 2, half_width = ShipPlan::container_width_m / 2;
    const double wave = (2 * half_length - 2 * door_m) / waves;
    std::vector<Vec2d> left{{-half_length, -half_width}};
    for (int i = 0; i < waves; ++i) {
        const double x = door_m - half_length + i * wave;
        left.emplace_back(x, -half_width);
        left.emplace_back(x + 0.25 * wave, depth_m - half_width);
        left.emplace_back(x + 0.75 * wave, depth_m - half_width);
    }
    left.emplace_back(half_length - door_m, -half_width);
    left.emplace_back(half_length, -half_width);
    std::vector<Vec2d> right = left;
    for (Vec2d& p : right) p.y = -p.y;
    use(builder, paint);
    builder.prism(frame, left, right, ShipPlan::container_height_m - 0.04);
}

void add_railing(ShapeBuilder& builder, const std::array<Vec3d, railing_posts + 1>& feet) {
    constexpr double height_m = 1.1;
    use(builder, Paint::white);
    for (std::size_t i = 0; i < railing_posts; ++i) builder.rod(feet[i], feet[i] + Vec3d{0, height_m, 0}, 0.035, 4);
    for (const double level : {0.4, 0.75, 1.1}) {
        auto rail = feet;
        for (Vec3d& p : rail) p.y += level;
        builder.pipe(rail, 0.025, 4);
    }
}

void add_pipe_run(ShapeBuilder& builder, const std::function<Vec3d(double, double)>& at, double from, double to,
                  double length_m, int lane, double radius_m) {
    const double third = (to - from) / 3, third_m = length_m / 3;
    const double low = 0.5, high = low + std::min(0.4, 0.3 * third_m);
    const std::array<Vec3d, 6> path{{at(from, low), at(from + third, low), at(from + 1.1 * third, high),
                                     at(from + 1.5 * third, high), at(from + 1.6 * third, low), at(to, low)}};
    use(builder, lane % 2 == 0 ? Paint::steel : Paint::green);
    builder.pipe(path, std::min(radius_m, 0.1 * third_m), 8);
    for (const double t : {from, from + 0.5 * third, from + 2.2 * third}) {
        const Vec3d foot = at(t, 0);
        builder.rod(foot, foot + Vec3d{0, 0.5, 0}, 0.06, 4);
    }
}

void add_bollard(ShapeBuilder& builder, const Frame& frame) {
    use(builder, Paint::steel);
    builder.box(moved(frame, {0, 0.06, 0}), {1.7, 0.12, 0.7});
    for (const double x : {-0.5, 0.5})
        lathe(builder, moved(frame, {x, 0.12, 0}),
              {{0.2, 0}, {0.2, 0.55}, {0.28, 0.62}, {0.28, 0.72}, {0.2, 0.78}, {0, 0.78}}, 10);
}

void add_window(ShapeBuilder& builder, const Frame& frame) {
    use(builder, Paint::steel);
    builder.box(frame, {0.12, 1.0, 0.9});
    use(builder, Paint::glass);
    builder.box(frame, {0.16, 0.8, 0.7});
}

void add_vent(ShapeBuilder& builder, const Frame& frame, double height_m) {
    const double h = height_m;
    use(builder, Paint::grey);
    lathe(builder, frame,
          {{0.3, 0}, {0.3, 0.12}, {0.18, 0.12}, {0.18, h}, {0.45, h}, {0.45, h + 0.2}, {0.25, h + 0.35}, {0, h + 0.4}},
          12);
}

void add_lamp(ShapeBuilder& builder, const Frame& frame) {
    use(builder, Paint::grey);
    builder.rod(frame.point({0, 0, 0}), frame.point({0, 4.5, 0}), 0.07, 6);
    builder.rod(frame.point({0, 4.4, 0}), frame.point({0, 4.6, -0.9}), 0.05, 6);
    use(builder, Paint::glass);
    builder.box(moved(frame, {0, 4.55, -1.0}), {0.5, 0.2, 0.4});
}

void add_ladder(ShapeBuilder& builder, const Frame& frame) {
    constexpr int rungs = 8;
    constexpr double h = ShipPlan::level_height_m;
    use(builder, Paint::yellow);
    for (const double x : {-0.25, 0.25}) builder.rod(frame.point({x, 0, 0}), frame.point({x, h, 0}), 0.035, 4);
    for (int i = 0; i < rungs; ++i) {
        const double y = (i + 0.5) * h / rungs;
        builder.rod(frame.point({-0.25, y, 0}), frame.point({0.25, y, 0}), 0.02, 4);
    }
}

void add_life_ring(ShapeBuilder& builder, const Frame& frame) {
    constexpr int steps = 6;
    std::vector<Vec2d> profile;
    for (int i = 0; i <= steps; ++i) {
        const double angle = -2 * pi * (i == steps ? 0 : i) / steps;
        profile.emplace_back(0.32 + 0.08 * std::cos(angle), -0.08 * std::sin(angle));
    }
    use(builder, Paint::orange);
    builder.lathe(along(frame.point({0, 1.0, 0}), frame.point({0, 1.0, 1.0})), profile, 12);
}

}  // namespace lodestream::samples
