// What a cargo ship is made of. Each function adds one object.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <random>

#include "server/samples/shape_builder.h"

namespace lodestream::samples {

enum class Paint : std::uint32_t {
    antifouling,
    hull,
    deck,
    white,
    steel,
    yellow,
    orange,
    glass,
    red,
    blue,
    green,
    grey,
    count
};

// Everything that the parts agree on. Metres; x towards the bow, y up, the waterline at 0, z to starboard.
struct ShipPlan {
    double length, beam, draft, freeboard;
    int bays, rows, tiers;  // of containers
    int crane_every;        // bays
    int house_levels;

    double deck_y(double t) const;  // t: 0 stern … 1 bow
    double deck_half_beam(double t) const;
    double x(double t) const { return (t - 0.5) * length; }
    double house_x() const { return x(0.11); }
    double house_length() const { return 0.08 * length; }
    double house_width() const { return 0.8 * beam; }
    double house_top() const { return deck_y(0.11) + house_levels * level_height_m; }
    double bay_x(int bay) const { return x(0.18) + (bay + 0.5) * bay_pitch_m; }
    double stack_y() const { return deck_y(0.5) + hatch_height_m; }

    static constexpr double level_height_m = 2.8;
    static constexpr double hatch_height_m = 1.8;
    static constexpr double container_length_m = 6.06, container_width_m = 2.44, container_height_m = 2.59;
    static constexpr double bay_pitch_m = 6.8, row_pitch_m = 2.54;
};

Frame container_place(const ShipPlan& plan, int bay, int row, int tier);
Frame window_place(const ShipPlan& plan, double position, int level, bool aft);
Frame ladder_place(const ShipPlan& plan, int level, int side, double position);

// A place on the deck: `t` along the ship, `side` -1 port or +1 starboard, `inset_m` from the deck's edge.
Frame on_deck(const ShipPlan& plan, double t, int side, double inset_m);

void add_hull(ShapeBuilder& builder, const ShipPlan& plan);
void add_house_level(ShapeBuilder& builder, const ShipPlan& plan, int level);
void add_bridge(ShapeBuilder& builder, const ShipPlan& plan);
void add_funnel(ShapeBuilder& builder, const ShipPlan& plan);
void add_forecastle(ShapeBuilder& builder, const ShipPlan& plan);
void add_foremast(ShapeBuilder& builder, const ShipPlan& plan);
void add_bulb(ShapeBuilder& builder, const ShipPlan& plan);
void add_propeller(ShapeBuilder& builder, const ShipPlan& plan);
void add_rudder(ShapeBuilder& builder, const ShipPlan& plan);
void add_crane(ShapeBuilder& builder, const ShipPlan& plan, int bay, double slew);
void add_lifeboat(ShapeBuilder& builder, const ShipPlan& plan, int side);
void add_anchor(ShapeBuilder& builder, const ShipPlan& plan, int side);
void add_winch(ShapeBuilder& builder, const Frame& frame);
void add_radar(ShapeBuilder& builder, const ShipPlan& plan, int which, double bearing);
void add_radome(ShapeBuilder& builder, const ShipPlan& plan, int side);
void add_hatch_cover(ShapeBuilder& builder, const ShipPlan& plan, int bay, int half);
void add_container(ShapeBuilder& builder, const Frame& frame, Paint paint, int waves);
constexpr int railing_posts = 3;
void add_railing(ShapeBuilder& builder, const std::array<Vec3d, railing_posts + 1>& feet);  // along a deck's edge
// `at`: the place so far along the deck's edge and so high. From one place along it to another, `length_m` in metres.
void add_pipe_run(ShapeBuilder& builder, const std::function<Vec3d(double, double)>& at, double from, double to,
                  double length_m, int lane, double radius_m);
void add_bollard(ShapeBuilder& builder, const Frame& frame);
void add_window(ShapeBuilder& builder, const Frame& frame);
void add_vent(ShapeBuilder& builder, const Frame& frame, double height_m);
void add_lamp(ShapeBuilder& builder, const Frame& frame);
void add_ladder(ShapeBuilder& builder, const Frame& frame);
void add_life_ring(ShapeBuilder& builder, const Frame& frame);

}  // namespace lodestream::samples
