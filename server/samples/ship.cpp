// Lays out the ship: the parts that make it a ship first, then deck gear and containers in fixed proportions.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "server/samples/count_limits.h"
#include "server/samples/samples.h"
#include "server/samples/ship_parts.h"

namespace lodestream::samples {
namespace {

using Part = std::function<void(ShapeBuilder&)>;

// Uniform in [0, 1) with the same bits on every platform, which std::uniform_real_distribution does not promise.
class Random {
  public:
    explicit Random(std::uint64_t seed) : engine_(seed) {}
    double operator()() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
    double between(double low, double high) { return std::lerp(low, high, (*this)()); }
    int below(int n) { return std::min(n - 1, static_cast<int>((*this)() * n)); }

  private:
    std::mt19937_64 engine_;
};

// Share of the objects that are left after the parts that make it a ship.
constexpr double railing_share = 0.18, pipe_share = 0.08, bollard_share = 0.04, window_share = 0.10, vent_share = 0.05,
                 lamp_share = 0.03, ladder_share = 0.02, ring_share = 0.02;

ShipPlan make_plan(std::uint64_t objects) {
    const double scale = std::max(0.35, std::cbrt(static_cast<double>(objects) / static_cast<double>(ship_objects)));
    ShipPlan plan{};
    plan.length = 220 * scale;
    plan.beam = 33 * scale;
    plan.draft = 10.5 * scale;
    plan.freeboard = 8 * scale;
    plan.bays = static_cast<int>((0.88 - 0.18) * plan.length / ShipPlan::bay_pitch_m);
    plan.rows = static_cast<int>((plan.beam - 4.0) / ShipPlan::row_pitch_m);
    plan.crane_every = std::max(3, plan.bays / 4);
    const int cranes = plan.bays / plan.crane_every, places = (plan.bays - cranes) * plan.rows;
    plan.tiers = static_cast<int>(std::ceil(0.48 * static_cast<double>(objects) / places));
    plan.house_levels = std::max(3, plan.tiers + 2);
    return plan;
}

bool has_crane(const ShipPlan& plan, int bay) {
    return bay % plan.crane_every == plan.crane_every - 1;
}

std::vector<Part> main_parts(const ShipPlan& plan, Random& random) {
    std::vector<Part> parts;
    const auto add = [&](auto part) { parts.emplace_back([plan, part](ShapeBuilder& b) { part(b, plan); }); };
    add(add_hull);
    for (int level = 0; level < plan.house_levels; ++level)
        add([level](ShapeBuilder& b, const ShipPlan& p) { add_house_level(b, p, level); });
    add(add_bridge);
    add(add_funnel);
    add(add_foremast);
    for (int bay = 0; bay < plan.bays; ++bay) {
        if (!has_crane(plan, bay)) continue;
        const double slew = random.between(-0.25, 0.25);
        add([=](ShapeBuilder& b, const ShipPlan& p) { add_crane(b, p, bay, slew); });
    }
    add(add_forecastle);
    add(add_bulb);
    add(add_rudder);
    add(add_propeller);
    for (const int side : {-1, 1}) {
        add([=](ShapeBuilder& b, const ShipPlan& p) { add_lifeboat(b, p, side); });
        add([=](ShapeBuilder& b, const ShipPlan& p) { add_anchor(b, p, side); });
        add([=](ShapeBuilder& b, const ShipPlan& p) { add_radome(b, p, side); });
        add([=](ShapeBuilder& b, const ShipPlan& p) { add_winch(b, on_deck(p, 0.925, side, 0.25 * p.beam)); });
        add([=](ShapeBuilder& b, const ShipPlan& p) { add_winch(b, on_deck(p, 0.02, side, 0.12 * p.beam)); });
    }
    for (const int which : {0, 1}) {
        const double bearing = random.between(0, 2 * pi);
        add([=](ShapeBuilder& b, const ShipPlan& p) { add_radar(b, p, which, bearing); });
    }
    for (int bay = 0; bay < plan.bays; ++bay)
        for (const int half : {0, 1})
            if (!has_crane(plan, bay))
                add([=](ShapeBuilder& b, const ShipPlan& p) { add_hatch_cover(b, p, bay, half); });
    return parts;
}

// The k-th of n gear places along both sides of the deck, starboard at odd k.
struct DeckPlace {
    double t;
    int side;
    double step;  // in t, to the next place on this side
};

DeckPlace deck_place(std::uint64_t k, std::uint64_t n, double from, double to) {
    const std::uint64_t pairs = (n + 1) / 2, pair = k / 2;
    const double step = (to - from) / static_cast<double>(pairs);
    return {from + (static_cast<double>(pair) + 0.5) * step, k % 2 == 0 ? -1 : 1, step};
}

// What the fine ship's shapes have more of.
constexpr int container_waves = 3, fine_container_waves = 39;  // on a side
constexpr int fine_roundness = 3;                              // sides over those of the plain ship

// Parts that are alike wherever they stand; each paint's container is one more.
enum Shape : std::size_t {
    railing,
    pipe_run,
    green_pipe_run,
    bollard,
    window,
    vent,
    lamp,
    ladder,
    life_ring,
    container
};
constexpr std::size_t shape_count = container + static_cast<std::size_t>(Paint::count);

constexpr double vent_height_m = 1.2;  // of the shape; vents are stretched

// From a frame's coordinates into those that it stands in, stretched along its axes.
Mat4d matrix_of(const Frame& frame, const Vec3d& scale = Vec3d(1.0)) {
    return {Vec4d(frame.x * scale.x, 0), Vec4d(frame.y * scale.y, 0), Vec4d(frame.z * scale.z, 0),
            Vec4d(frame.origin, 1)};
}

// y up, x from one place to another and as long as that is.
Mat4d stretched_between(const Vec3d& from, const Vec3d& to) {
    const Vec3d up{0, 1, 0};
    return {Vec4d(to - from, 0), Vec4d(up, 0), Vec4d(normalize(cross(to - from, up)), 0), Vec4d(from, 1)};
}

// Where the ship's parts are put: all into one mesh or, fine, those that are alike as instances of one shape.
class Yard {
  public:
    Yard(const ShipPlan& plan, bool is_fine) : plan_(plan), is_fine_(is_fine) {}

    using Add = std::function<void(ShapeBuilder&, const Frame&)>;

    ShapeBuilder& next_object() {
        solid_.begin_object();
        return solid_;
    }

    void put(std::size_t shape, const Frame& place, const Add& add) {
        if (!is_fine_) return add(next_object(), place);
        instance(shape, matrix_of(place), [&](ShapeBuilder& builder) { add(builder, {}); });
    }

    void put_railing(double from, double to, int side) {
        std::array<Vec3d, railing_posts + 1> feet, shape_feet;
        for (std::size_t i = 0; i < feet.size(); ++i) {
            const double share = static_cast<double>(i) / railing_posts;
            feet[i] = on_deck(plan_, std::lerp(from, to, share), side, 0.15).origin;
            shape_feet[i] = {share, 0, 0};
        }
        if (!is_fine_) return add_railing(next_object(), feet);
        instance(railing, stretched_between(feet.front(), feet.back()),
                 [&](ShapeBuilder& builder) { add_railing(builder, shape_feet); });
    }

    void put_pipe_run(double from, double to, int side, int lane, double radius_m) {
        const double inset = 1.0 + 0.45 * lane;
        const auto at = [&](double t, double up) { return on_deck(plan_, t, side, inset).origin + Vec3d{0, up, 0}; };
        if (!is_fine_) return add_pipe_run(next_object(), at, from, to, (to - from) * plan_.length, lane, radius_m);
        instance(lane % 2 == 0 ? pipe_run : green_pipe_run, stretched_between(at(from, 0), at(to, 0)),
                 [&](ShapeBuilder& builder) {
                     const auto on_axis = [](double x, double up) { return Vec3d{x, up, 0}; };
                     add_pipe_run(builder, on_axis, 0.0, 1.0, 1.0, lane, radius_m);
                 });
    }

    void put_vent(const Frame& place, double height_m) {
        if (!is_fine_) return add_vent(next_object(), place, height_m);
        instance(vent, matrix_of(place, {1, height_m / vent_height_m, 1}),
                 [](ShapeBuilder& builder) { add_vent(builder, {}, vent_height_m); });
    }

    int waves() const { return is_fine_ ? fine_container_waves : container_waves; }

    mesh::Model finish() {
        mesh::Model model;
        model.kind = mesh::Kind::scene;
        model.objects = objects();
        model.graph = mesh::flat_graph(model.objects);
        model.mesh = solid_.take();
        model.shapes = std::move(shapes_);
        model.instances = std::move(instances_);
        return model;
    }

  private:
    std::uint32_t objects() const { return solid_.objects() + static_cast<std::uint32_t>(instances_.size()); }

    void instance(std::size_t shape, const Mat4d& matrix, const std::function<void(ShapeBuilder&)>& add) {
        if (!places_[shape]) {
            ShapeBuilder builder(fine_roundness);
            add(builder);
            places_[shape] = static_cast<std::uint32_t>(shapes_.size());
            shapes_.push_back(builder.take());
        }
        instances_.push_back({objects(), *places_[shape], matrix});
    }

    const ShipPlan& plan_;
    const bool is_fine_;
    ShapeBuilder solid_;
    std::array<std::optional<std::uint32_t>, shape_count> places_;  // of each in shapes_
    std::vector<mesh::Mesh> shapes_;
    std::vector<mesh::Instance> instances_;
};

void add_gear(Yard& yard, const ShipPlan& plan, Random& random, std::uint64_t objects) {
    const auto each = [&](double share, auto place) {
        const auto n = static_cast<std::uint64_t>(share * static_cast<double>(objects));
        for (std::uint64_t k = 0; k < n; ++k) place(k, n);
    };
    each(railing_share, [&](std::uint64_t k, std::uint64_t n) {
        const DeckPlace at = deck_place(k, n, 0.01, 0.9);
        yard.put_railing(at.t - 0.5 * at.step, at.t + 0.5 * at.step, at.side);
    });
    each(pipe_share, [&](std::uint64_t k, std::uint64_t n) {
        constexpr std::uint64_t lanes = 3;
        const DeckPlace at = deck_place(k / lanes, n / lanes + 1, 0.17, 0.88);
        yard.put_pipe_run(at.t - 0.48 * at.step, at.t + 0.48 * at.step, at.side, static_cast<int>(k % lanes),
                          random.between(0.08, 0.16));
    });
    each(bollard_share, [&](std::uint64_t k, std::uint64_t n) {
        const DeckPlace at = deck_place(k, n, 0.01, 0.97);
        yard.put(bollard, on_deck(plan, at.t, at.side, 0.6), add_bollard);
    });
    each(window_share, [&](std::uint64_t k, std::uint64_t n) {
        const auto levels = static_cast<std::uint64_t>(plan.house_levels);
        const std::uint64_t columns = std::max<std::uint64_t>(1, (n + 2 * levels - 1) / (2 * levels));
        const std::uint64_t column = k / (2 * levels);
        const double position = (static_cast<double>(column) + 0.5) / static_cast<double>(columns);
        yard.put(window, window_place(plan, position, static_cast<int>(k / 2 % levels), k % 2 == 1), add_window);
    });
    each(vent_share, [&](std::uint64_t k, std::uint64_t n) {
        const DeckPlace at = deck_place(k, n, 0.03, 0.95);
        yard.put_vent(on_deck(plan, at.t, at.side, 2.6), random.between(0.8, 1.6));
    });
    each(lamp_share, [&](std::uint64_t k, std::uint64_t n) {
        const DeckPlace at = deck_place(k, n, 0.02, 0.93);
        yard.put(lamp, on_deck(plan, at.t, at.side, 0.4), add_lamp);
    });
    each(ladder_share, [&](std::uint64_t k, std::uint64_t n) {
        const auto level = static_cast<int>(k / 2 % static_cast<std::uint64_t>(plan.house_levels));
        const double position = (static_cast<double>(k) + 0.5) / static_cast<double>(n);
        yard.put(ladder, ladder_place(plan, level, k % 2 == 0 ? -1 : 1, position), add_ladder);
    });
    each(ring_share, [&](std::uint64_t k, std::uint64_t n) {
        const DeckPlace at = deck_place(k, n, 0.02, 0.9);
        yard.put(life_ring, on_deck(plan, at.t, at.side, 0.1), add_life_ring);
    });
}

std::uint64_t gear_count(std::uint64_t objects) {
    std::uint64_t count = 0;
    for (const double share :
         {railing_share, pipe_share, bollard_share, window_share, vent_share, lamp_share, ladder_share, ring_share})
        count += static_cast<std::uint64_t>(share * static_cast<double>(objects));
    return count;
}

// Stacks are laid tier by tier, each tier in random order, so that only the last one is ragged.
void add_containers(Yard& yard, const ShipPlan& plan, Random& random, std::uint64_t count) {
    constexpr std::array colors{Paint::red, Paint::blue, Paint::green, Paint::orange, Paint::grey, Paint::white};
    struct Stack {
        int bay, row;
    };
    std::vector<Stack> stacks;
    for (int bay = 0; bay < plan.bays; ++bay)
        for (int row = 0; row < plan.rows; ++row)
            if (!has_crane(plan, bay)) stacks.push_back({bay, row});
    for (std::uint64_t placed = 0; placed < count;) {
        const int tier = static_cast<int>(placed / stacks.size());
        for (std::size_t i = stacks.size() - 1; i > 0; --i)
            std::swap(stacks[i], stacks[static_cast<std::size_t>(random.below(static_cast<int>(i) + 1))]);
        for (std::size_t i = 0; i < stacks.size() && placed < count; ++i, ++placed) {
            const Paint paint = colors[static_cast<std::size_t>(random.below(static_cast<int>(colors.size())))];
            yard.put(
                container + static_cast<std::size_t>(paint), container_place(plan, stacks[i].bay, stacks[i].row, tier),
                [&](ShapeBuilder& builder, const Frame& frame) { add_container(builder, frame, paint, yard.waves()); });
        }
    }
}

mesh::Material paint(const char* name, const Vec3f& color, float roughness) {
    mesh::Material material;
    material.name = name;
    material.base_color = Vec4f(color, 1.0f);
    material.roughness = roughness;
    return material;
}

// In the order of Paint.
std::vector<mesh::Material> paints() {
    return {paint("antifouling", {0.33f, 0.04f, 0.03f}, 0.8f), paint("hull", {0.02f, 0.04f, 0.10f}, 0.5f),
            paint("deck", {0.10f, 0.22f, 0.16f}, 0.9f),        paint("white", {0.80f, 0.80f, 0.76f}, 0.5f),
            paint("steel", {0.12f, 0.12f, 0.13f}, 0.6f),       paint("yellow", {0.80f, 0.50f, 0.04f}, 0.5f),
            paint("orange", {0.80f, 0.20f, 0.02f}, 0.5f),      paint("glass", {0.02f, 0.05f, 0.08f}, 0.1f),
            paint("red", {0.45f, 0.05f, 0.04f}, 0.6f),         paint("blue", {0.04f, 0.14f, 0.42f}, 0.6f),
            paint("green", {0.05f, 0.28f, 0.12f}, 0.6f),       paint("grey", {0.38f, 0.39f, 0.40f}, 0.6f)};
}

Result<mesh::Model> make_ship(std::uint64_t objects, std::uint64_t seed, bool is_fine) {
    if (auto error = outside("ship objects", objects, min_ship_objects, max_ship_objects)) return *error;
    const ShipPlan plan = make_plan(objects);
    Random random(seed);

    Yard yard(plan, is_fine);
    const std::vector<Part> parts = main_parts(plan, random);
    const std::uint64_t main = std::min<std::uint64_t>(parts.size(), objects), rest = objects - main;
    for (std::uint64_t i = 0; i < main; ++i) parts[i](yard.next_object());
    add_gear(yard, plan, random, rest);
    add_containers(yard, plan, random, rest - gear_count(rest));

    mesh::Model model = yard.finish();
    model.materials = paints();
    return model;
}

}  // namespace

Result<mesh::Model> ship(std::uint64_t objects, std::uint64_t seed) {
    return make_ship(objects, seed, false);
}

Result<mesh::Model> fine_ship(std::uint64_t objects, std::uint64_t seed) {
    return make_ship(objects, seed, true);
}

}  // namespace lodestream::samples
