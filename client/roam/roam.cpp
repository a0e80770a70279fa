#include "client/roam/roam.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "client/fly/scenery.h"
#include "client/sdk/client.h"
#include "common/scene/fade.h"

namespace lodestream::roam {

namespace {

using Clock = std::chrono::steady_clock;

constexpr double near_share = 1e-4;  // of the scene's radius

double ms_since(Clock::time_point start) {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

Status check(const RoamOptions& options) {
    if (!(options.fps >= min_fps && options.fps <= max_fps)) return invalid_input("frames a second must be 1 to 1000");
    if (!(options.fade_s >= 0.0) || !std::isfinite(options.fade_s)) return invalid_input("a fade's time is negative");
    if (!(options.stream.tolerance_px >= 0.0)) return invalid_input("the tolerance is negative");
    if (options.stream.max_requests == 0) return invalid_input("at least one request must be allowed");
    return Nothing{};
}

std::vector<std::uint64_t> guessed_bytes(std::vector<std::uint64_t> encoded) {
    for (std::uint64_t& bytes : encoded) bytes = gpu_bytes_per_byte * std::min(bytes, sdk::max_content_bytes);
    return encoded;
}

// What was drawn in a frame, to be drawn again in the next one's view.
using Drawn = std::vector<render::DrawnPart>;

bool is_same(Drawn a, Drawn b) {
    const auto key = [](const render::DrawnPart& d) { return std::tuple(d.part, d.share.from, d.share.to); };
    std::ranges::sort(a, {}, key);
    std::ranges::sort(b, {}, key);
    return std::ranges::equal(a, b, {}, key, key);
}

// Of each node of `newer` the node of `older` that is the same tile, or none.
std::vector<std::uint32_t> same_tiles(const proto::Tileset& older, const proto::Tileset& newer) {
    const auto id = [](const proto::Tileset& tileset, std::uint32_t node) {
        return tileset.ids.empty() ? node : tileset.ids[node];  // before its first change a scene tells none
    };
    std::unordered_map<std::uint64_t, std::uint32_t> nodes;
    for (std::uint32_t node = 0; node < older.nodes.size(); ++node) nodes.emplace(id(older, node), node);
    std::vector<std::uint32_t> same(newer.nodes.size(), scene::none);
    for (std::uint32_t node = 0; node < same.size(); ++node)
        if (const auto found = nodes.find(id(newer, node)); found != nodes.end()) same[node] = found->second;
    return same;
}

bool shows_the_same(const proto::Tileset& a, std::uint32_t i, const proto::Tileset& b, std::uint32_t k) {
    return a.uris[i] == b.uris[k] && a.matrix(i) == b.matrix(k);
}

class Roamer {
  public:
    Roamer(render::Renderer& renderer, proto::Tileset tileset, Tiles& tiles, const RoamOptions& options)
        : renderer_(renderer),
          tileset_(std::move(tileset)),
          tiles_(tiles),
          options_(options),
          residency_(guessed_bytes(tileset_.bytes)),
          fade_step_(options.fade_s > 0.0 ? 1.0 / (options.fade_s * options.fps) : 1.0) {
        tiles_.adopt(tileset_);
    }

    Status draw_frame(double t_s, const shading::View& seen) {
        const scene::View view = view_of(seen);
        if (Status valid = scene::validate(view); !valid) return valid;
        if (options_.newer)
            if (auto newer = options_.newer()) adopt(*std::move(newer));
        if (Status received = receive(t_s); !received) return received;
        const scene::StreamStep now = step(view);
        want(now.requests, t_s);
        if (options_.open) options_.open(documents_for(view, now));
        const auto shown = scene::fade(tree(), fading_, now.drawn, view, fade_step_);
        RoamFrame frame;
        frame.t_s = t_s;
        frame.tiles = now.drawn.size();
        frame.missing_tiles = now.missing;
        frame.outdated_tiles = static_cast<std::size_t>(
            std::ranges::count_if(now.drawn, [&](std::uint32_t node) { return outdated_.contains(node); }));
        frame.fetched_bytes = fetched_bytes_;
        frame.gpu_bytes = residency_.held_bytes;
        tell_errors(view, now.drawn, shown, frame);
        if (Status drawn = draw(seen, shown, frame); !drawn) return drawn;
        for (const std::uint32_t node : now.dropped) release(node);
        roamed_.frames.push_back(frame);
        return Nothing{};
    }

    Roamed finish() { return std::move(roamed_); }

  private:
    scene::View view_of(const shading::View& seen) const {
        scene::View view = scene::view_towards(seen.eye, seen.target);
        view.fov_y_deg = seen.fov_y_deg;
        view.width = options_.width;
        view.height = options_.height;
        const double radius = tree().front().box.radius();
        view.near = near_share * (radius > 0.0 ? radius : 1.0);
        return view;
    }

    const scene::LodTree& tree() const { return tileset_.nodes; }

    // What is here of the tileset before becomes that of the same tiles in this one, as far as tiles above them are
    // here too; where they show something else by now, they are outdated.
    void adopt(proto::Tileset newer) {
        const proto::Tileset older = std::exchange(tileset_, std::move(newer));
        const scene::Residency before = std::exchange(residency_, scene::Residency(guessed_bytes(tileset_.bytes)));
        residency_.frame = before.frame;
        const std::map<std::uint32_t, std::uint32_t> old_parts = std::exchange(parts_, {});
        const std::set<std::uint32_t> old_outdated = std::exchange(outdated_, {});
        const std::vector<std::uint32_t> old_nodes = same_tiles(older, tileset_);
        std::vector<std::uint32_t> new_nodes(older.nodes.size(), scene::none);
        for (std::uint32_t node = 0; node < old_nodes.size(); ++node) {
            const std::uint32_t old = old_nodes[node];
            if (old == scene::none || !before.has(old)) continue;
            if (node != 0 && !residency_.has(tree()[node].parent)) continue;
            residency_.bytes[node] = before.bytes[old];
            residency_.last_used[node] =
                node == 0 ? before.last_used[old]
                          : std::min(before.last_used[old], residency_.last_used[tree()[node].parent]);
            residency_.held_bytes += residency_.bytes[node];
            parts_[node] = old_parts.at(old);
            new_nodes[old] = node;
            if (old_outdated.contains(old) || !shows_the_same(older, old, tileset_, node)) outdated_.insert(node);
        }
        for (const auto& [old, part] : old_parts)
            if (new_nodes[old] == scene::none) renderer_.remove(part);
        move_fading(new_nodes);
        drawn_.clear();
        early_.clear();
        attempts_.clear();
        tiles_.adopt(tileset_);
        ++roamed_.revisions;
    }

    // Levels go on fading where all that is on the screen is still there and a cut; else the next cut is shown at once.
    void move_fading(const std::vector<std::uint32_t>& new_nodes) {
        bool is_whole = true;
        const auto move = [&](std::uint32_t& node) {
            node = new_nodes[node];
            is_whole = is_whole && node != scene::none;
        };
        const auto move_all = [&](std::vector<std::uint32_t>& nodes) { std::ranges::for_each(nodes, move); };
        move_all(fading_.settled);
        for (scene::Transition& transition : fading_.transitions) {
            move(transition.top);
            move_all(transition.going);
            move_all(transition.coming);
        }
        if (is_whole) is_whole = scene::is_cut(tree(), scene::coming_nodes(fading_));
        if (!is_whole) fading_ = {};
    }

    // But for those that are here and wait for what is above them. What is outdated and in use comes first.
    void want(std::vector<std::uint32_t> requests, double t_s) {
        std::vector<std::uint32_t> first;
        for (const std::uint32_t node : outdated_)
            if (residency_.last_used[node] == residency_.frame && first.size() < options_.stream.max_requests)
                first.push_back(node);
        requests.insert(requests.begin(), first.begin(), first.end());
        std::erase_if(early_, [&](const auto& entry) { return std::ranges::count(requests, entry.first) == 0; });
        std::erase_if(requests, [&](std::uint32_t node) { return early_.contains(node); });
        tiles_.want(requests, t_s);
    }

    // Of what is drawn or under way and too coarse for the view.
    std::vector<std::string> documents_for(const scene::View& view, const scene::StreamStep& now) const {
        const scene::Projection projection(view);
        std::vector<std::pair<double, std::uint32_t>> coarse;
        const auto add = [&](std::uint32_t node) {
            if (!proto::begins_document(tileset_, node)) return;
            const double error_px = projection.error_px(tree()[node].box, tree()[node].error);
            if (error_px > options_.stream.tolerance_px) coarse.emplace_back(-error_px, node);
        };
        std::ranges::for_each(now.drawn, add);
        std::ranges::for_each(now.requests, add);
        std::ranges::sort(coarse);
        std::vector<std::string> documents;
        for (const auto& [error_px, node] : coarse) documents.push_back(tileset_.documents[node]);
        return documents;
    }

    Status receive(double t_s) {
        for (Arrival& arrival : tiles_.take(t_s)) {
            if (arrival.part) {
                ++roamed_.fetched_tiles;
                fetched_bytes_ += tileset_.bytes[arrival.node];
                warn_of(arrival.part.warnings);
                early_.insert_or_assign(arrival.node, *std::move(arrival.part));
            } else if (Status missed = miss(arrival.node, arrival.part.error()); !missed) {
                return missed;
            }
        }
        // In rising order, so parents are kept before their children.
        for (auto tile = early_.begin(); tile != early_.end();) {
            const auto [node, part] = *tile;
            if (node != 0 && !residency_.has(tree()[node].parent)) {
                ++tile;
                continue;
            }
            tile = early_.erase(tile);
            if (Status kept = keep(node, part); !kept) return kept;
        }
        return Nothing{};
    }

    Status keep(std::uint32_t node, const render::Part& part) {
        if (residency_.has(node) && !outdated_.contains(node)) return Nothing{};
        if (!residency_.has(node)) {
            residency_.bytes[node] = part.gpu_bytes;
            if (!arrive(tree(), residency_, node, options_.stream)) return Nothing{};
        } else {
            residency_.held_bytes += part.gpu_bytes - residency_.bytes[node];
            residency_.bytes[node] = part.gpu_bytes;
            outdated_.erase(node);
            std::erase_if(drawn_, [&](const render::DrawnPart& d) { return d.part == parts_.at(node); });
            renderer_.remove(parts_.at(node));
        }
        const auto start = Clock::now();
        const auto added = renderer_.add(part);
        if (!added) return added.error();
        upload_ms_ += ms_since(start);
        warn_of(added.warnings);
        parts_[node] = *added;
        return Nothing{};
    }

    void warn_of(const std::vector<std::string>& warnings) {
        roamed_.warnings.insert(roamed_.warnings.end(), warnings.begin(), warnings.end());
    }

    // What the network failed to bring may come at another time; what cannot be decoded will not.
    Status miss(std::uint32_t node, const Error& error) {
        const bool may_come = error.code == ErrorCode::io || error.code == ErrorCode::unavailable;
        if (may_come && ++attempts_[node] < max_attempts) return Nothing{};
        fetched_bytes_ += may_come ? 0 : tileset_.bytes[node];
        if (node == 0 && !outdated_.contains(node)) return error;
        roamed_.failures.push_back(error.message);
        if (outdated_.erase(node) > 0) return Nothing{};  // what it showed before stays
        give_up(tree(), residency_, node);
        return Nothing{};
    }

    scene::StreamStep step(const scene::View& view) {
        std::vector<scene::View> coming;
        if (options_.looks_ahead && before_)
            for (const double s : ahead_s) coming.push_back(scene::ahead_of(*before_, view, s * options_.fps));
        before_ = view;
        return scene::step(tree(), residency_, view, options_.stream, coming, scene::shown_nodes(fading_));
    }

    void tell_errors(const scene::View& view, const std::vector<std::uint32_t>& cut,
                     const std::vector<scene::FadingNode>& shown, RoamFrame& frame) const {
        const scene::Projection projection(view);
        const auto error_px = [&](std::uint32_t node) {
            return projection.error_px(tree()[node].box, tree()[node].error);
        };
        for (const std::uint32_t node : cut)
            frame.missed_px += std::max(0.0, error_px(node) - options_.stream.tolerance_px);
        for (const scene::FadingNode& node : shown) {
            frame.error_px = std::max(frame.error_px, error_px(node.node));
            frame.fading_tiles += node.from > 0.0 || node.to < 1.0 ? 1 : 0;
        }
    }

    // What comes into view in other levels than it had out of it does not pop.
    void replace_unseen() {
        for (const scene::Transition& unseen : fading_.unseen) {
            for (const std::uint32_t node : unseen.going)
                std::erase_if(drawn_, [&](const render::DrawnPart& d) { return d.part == parts_.at(node); });
            for (const std::uint32_t node : unseen.coming) drawn_.push_back({parts_.at(node)});
        }
    }

    // What is shown does not leave the residency, so all of the frame before is still here.
    Status draw(const shading::View& seen, const std::vector<scene::FadingNode>& shown, RoamFrame& frame) {
        Drawn drawn;
        for (const scene::FadingNode& node : shown) drawn.push_back({parts_.at(node.node), {node.from, node.to}});
        std::optional<render::Image> unchanged;
        replace_unseen();
        if (!drawn_.empty() && !is_same(drawn, drawn_)) {
            auto old = picture(seen, drawn_);
            if (!old) return old.error();
            unchanged = std::move(old->image);
        }
        auto picture_now = picture(seen, drawn);
        if (!picture_now) return picture_now.error();
        frame.frame_ms = std::exchange(upload_ms_, 0.0) + picture_now->frame_ms;
        frame.triangles = picture_now->triangles;
        frame.points = picture_now->points;
        if (unchanged) {
            const auto popping = popping_between(*unchanged, picture_now->image);
            if (!popping) return popping.error();
            frame.popping = *popping;
            frame.has_changed = true;
        }
        drawn_ = std::move(drawn);
        return options_.on_frame ? options_.on_frame(picture_now->image) : Nothing{};
    }

    Result<render::Frame> picture(const shading::View& seen, const Drawn& drawn) {
        render::DrawOptions drawing;
        drawing.width = options_.width;
        drawing.height = options_.height;
        drawing.samples = options_.samples;
        drawing.parts = drawn;
        return renderer_.draw(seen, drawing);
    }

    void release(std::uint32_t node) {
        renderer_.remove(parts_.at(node));
        parts_.erase(node);
        outdated_.erase(node);
    }

    render::Renderer& renderer_;
    proto::Tileset tileset_;
    Tiles& tiles_;
    const RoamOptions& options_;
    scene::Residency residency_;
    scene::Fading fading_;
    double fade_step_;
    std::optional<scene::View> before_;
    Drawn drawn_;
    std::map<std::uint32_t, std::uint32_t> parts_;  // of each node that is here, as the renderer names it
    std::set<std::uint32_t> outdated_;              // nodes that are here as they were before the scene changed
    std::map<std::uint32_t, render::Part> early_;   // came before what is above them
    std::map<std::uint32_t, int> attempts_;
    std::uint64_t fetched_bytes_ = 0;
    double upload_ms_ = 0.0;  // of the frame at hand
    Roamed roamed_;
};

}  // namespace

Result<Roamed> roam(render::Renderer& renderer, proto::Tileset tileset, Tiles& tiles, const motion::Trace& motion,
                    const shading::View& home, const RoamOptions& options) {
    if (Status sound = check(options); !sound) return sound.error();
    if (tileset.is_additive && !tileset.matrices.empty())
        return fail(ErrorCode::unsupported, "the tileset is of points that are moved");
    if (motion.empty()) return invalid_input("a motion needs at least one sample");
    const double frames = std::floor(motion::duration_s(motion) * options.fps) + 1.0;
    if (!(frames <= static_cast<double>(max_frames)))
        return fail(ErrorCode::limit_exceeded, "the motion has too many frames");
    if (Status begun = renderer.begin_scene(tileset.nodes.front().box); !begun) return begun.error();
    Roamer roamer(renderer, std::move(tileset), tiles, options);
    for (double frame = 0.0; frame < frames; ++frame) {
        const double t_s = frame / options.fps;
        if (options.wait_until) options.wait_until(t_s);
        const motion::Pose pose = motion::pose_at(motion, motion.front().t_s + t_s);
        if (Status drawn = roamer.draw_frame(t_s, fly::view_of(home, pose)); !drawn) return drawn.error();
    }
    return roamer.finish();
}

RoamSummary summarize(const Roamed& roamed) {
    RoamSummary out;
    out.frames = roamed.frames.size();
    if (roamed.frames.empty()) return out;
    const auto count = static_cast<double>(out.frames);
    out.first_picture_s = roamed.frames.back().t_s;
    for (const RoamFrame& frame : roamed.frames) {
        if (frame.tiles > 0) out.first_picture_s = std::min(out.first_picture_s, frame.t_s);
        out.mean_frame_ms += frame.frame_ms / count;
        out.worst_frame_ms = std::max(out.worst_frame_ms, frame.frame_ms);
        out.mean_error_px += frame.error_px / count;
        out.mean_missed_px += frame.missed_px / count;
        out.missing_frames += (frame.missing_tiles > 0 ? 1.0 : 0.0) / count;
        out.peak_gpu_bytes = std::max(out.peak_gpu_bytes, frame.gpu_bytes);
        out.changes += frame.has_changed ? 1 : 0;
        out.popping_largest = std::max(out.popping_largest, frame.popping.largest);
        out.popping_p999 = std::max(out.popping_p999, frame.popping.p999);
        out.popping_rms = std::max(out.popping_rms, frame.popping.rms);
    }
    return out;
}

}  // namespace lodestream::roam
