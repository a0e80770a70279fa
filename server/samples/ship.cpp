// Lays out the ship: the parts that make it a ship first, then deck gear and containers in fixed proportions.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <random>
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

void add_gear(ShapeBuilder& builder, const ShipPlan& plan, Random& random, std::uint64_t objects) {
    const auto each = [&](double share, auto place) {
        const auto n = static_cast<std::uint64_t>(share * static_cast<double>(objects));
        for (std::uint64_t k = 0; k < n; ++k) {
            builder.begin_object();
            place(k, n);
        }
    };
    each(railing_share, [&](std::uint64_t k, std::uint64_t n) {
        const DeckPlace at = deck_place(k, n, 0.01, 0.9);
        add_railing(builder, plan, at.t - 0.5 * at.step, at.t + 0.5 * at.step, at.side);
    });
    each(pipe_share, [&](std::uint64_t k, std::uint64_t n) {
        constexpr std::uint64_t lanes = 3;
        const DeckPlace at = deck_place(k / lanes, n / lanes + 1, 0.17, 0.88);
        add_pipe_run(builder, plan, at.t - 0.48 * at.step, at.t + 0.48 * at.step, at.side, static_cast<int>(k % lanes),
                     random.between(0.08, 0.16));
    });
    each(bollard_share, [&](std::uint64_t k, std::uint64_t n) {
        const DeckPlace at = deck_place(k, n, 0.01, 0.97);
        add_bollard(builder, on_deck(plan, at.t, at.side, 0.6));
    });
    each(window_share, [&](std::uint64_t k, std::uint64_t n) {
        const auto levels = static_cast<std::uint64_t>(plan.house_levels);
        const std::uint64_t columns = std::max<std::uint64_t>(1, (n + 2 * levels - 1) / (2 * levels));
        const std::uint64_t column = k / (2 * levels);
        add_window(builder, plan, (static_cast<double>(column) + 0.5) / static_cast<double>(columns),
                   static_cast<int>(k / 2 % levels), k % 2 == 1);
    });
    each(vent_share, [&](std::uint64_t k, std::uint64_t n) {
        const DeckPlace at = deck_place(k, n, 0.03, 0.95);
        add_vent(builder, on_deck(plan, at.t, at.side, 2.6), random.between(0.8, 1.6));
    });
    each(lamp_share, [&](std::uint64_t k, std::uint64_t n) {
        const DeckPlace at = deck_place(k, n, 0.02, 0.93);
        add_lamp(builder, on_deck(plan, at.t, at.side, 0.4));
    });
    each(ladder_share, [&](std::uint64_t k, std::uint64_t n) {
        const auto level = static_cast<int>(k / 2 % static_cast<std::uint64_t>(plan.house_levels));
        add_ladder(builder, plan, level, k % 2 == 0 ? -1 : 1, (static_cast<double>(k) + 0.5) / static_cast<double>(n));
    });
    each(ring_share, [&](std::uint64_t k, std::uint64_t n) {
        const DeckPlace at = deck_place(k, n, 0.02, 0.9);
        add_life_ring(builder, on_deck(plan, at.t, at.side, 0.1));
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
void add_containers(ShapeBuilder& builder, const ShipPlan& plan, Random& random, std::uint64_t count) {
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
            builder.begin_object();
            add_container(builder, plan, stacks[i].bay, stacks[i].row, tier,
                          colors[static_cast<std::size_t>(random.below(static_cast<int>(colors.size())))]);
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

}  // namespace

Result<mesh::Model> ship(std::uint64_t objects, std::uint64_t seed) {
    if (auto error = outside("ship objects", objects, min_ship_objects, max_ship_objects)) return *error;
    const ShipPlan plan = make_plan(objects);
    Random random(seed);

    ShapeBuilder builder;
    const std::vector<Part> parts = main_parts(plan, random);
    const std::uint64_t main = std::min<std::uint64_t>(parts.size(), objects), rest = objects - main;
    for (std::uint64_t i = 0; i < main; ++i) {
        builder.begin_object();
        parts[i](builder);
    }
    add_gear(builder, plan, random, rest);
    add_containers(builder, plan, random, rest - gear_count(rest));

    mesh::Model model;
    model.kind = mesh::Kind::scene;
    model.mesh = builder.take();
    model.materials = paints();
    model.objects = builder.objects();
    model.graph = mesh::flat_graph(model.objects);
    return model;
}

}  // namespace lodestream::samples
