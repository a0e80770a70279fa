// What is flown over: an asset's ladder, fetched and decoded, and where its viewer stands.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "client/render/movable_level.h"
#include "client/render/renderer.h"
#include "client/sdk/client.h"
#include "common/base/result.h"
#include "common/codec/level_codec.h"
#include "common/control/control.h"
#include "common/motion/motion.h"
#include "common/shading/view.h"

namespace lodestream::fly {

struct SceneryLevel {
    codec::Decoded content;
    std::uint64_t triangles = 0;
    double max_error = 0.0;  // model units, of the ladder; never less than that of the level before
    render::Part part{};     // the content as the GPU takes it, so that a switch copies it and does no more
    std::optional<render::MovableLevel> movable{};  // drawn in place of content and part, which are then empty
};

struct Scenery {
    std::vector<SceneryLevel> levels;  // 0 the finest, triangles falling
    Box bounds;                        // of the finest, world axes
    std::string kind;                  // the asset's: "mesh", "scene", "terrain", …
};

inline constexpr std::uint64_t all_triangles = ~0ull;

// Every level of the asset of this id or name that has at most `max_triangles`, or the coarsest alone where none has.
// Errors: not_found, unavailable (not baked), those of the client.
Result<Scenery> fetch_scenery(sdk::Client& client, const std::string& id_or_name,
                              std::uint64_t max_triangles = all_triangles);

// Sets the bounds and every level's part from the contents. Errors: those of render::prepare().
Status prepare(Scenery& scenery);

// Lets the border between Gouraud and flat move in every level. Errors: those of render::movable_level().
Status make_movable(Scenery& scenery);

// A scenery of the given levels alone. pre: indices rise and are below levels.size(), at least one
Scenery chosen(const Scenery& scenery, const std::vector<std::size_t>& indices);

// Levels as the controllers see them, in one view.
std::vector<control::Level> ladder_of(const Scenery& scenery, const shading::View& view,
                                      const budget::Display& display);

// Where the viewer stands when a motion gives no position: outside, the whole in view; of a terrain in its middle,
// above its highest point by 2 % of its width.
shading::View default_view(const Scenery& scenery, double fov_y_deg);

// Middles of some of the finest level's triangles, world axes, spread evenly over their order: what tells how much of
// the scenery a view shows.
std::vector<Vec3d> sampled_triangles(const Scenery& scenery);

// Share of the points within the picture, hidden ones included; 1 for no points. pre: validate(view) succeeded
double share_in_view(std::span<const Vec3d> points, const shading::View& view, const budget::Display& display);

// A pose's heading and pitch are absolute where it has a position and relative to the default view where it has none.
shading::View view_of(const shading::View& default_view, const motion::Pose& pose);

}  // namespace lodestream::fly
