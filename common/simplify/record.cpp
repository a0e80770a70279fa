// The conductor of a recording: large surfaces are first simplified region by region, side by side; then what is left
// as a whole, down to one triangle.
#include <algorithm>
#include <atomic>
#include <limits>
#include <new>
#include <numeric>
#include <span>

#include "common/simplify/assemble.h"
#include "common/simplify/components.h"
#include "common/simplify/history.h"
#include "common/simplify/regions.h"
#include "common/simplify/surface.h"
#include "common/simplify/worker.h"

namespace lodestream::simplify {

namespace {

constexpr std::size_t region_faces = 1u << 13;  // smaller regions have much border, larger ones leave the caches
constexpr std::size_t min_divided_faces = 1u << 13;
constexpr double region_share = 0.3;    // of a region's triangles that are left when it is done at the latest
constexpr double max_share_left = 0.9;  // after a round; else regions are of no use to this surface
// A round makes no merge that costs more than this share of the edges now, so that regions stay alike and their
// borders, which lie inside the next round's regions, do not fall far behind.
constexpr double merged_quantile = 0.8;
constexpr std::size_t sampled_positions = 64;  // one of so many is asked for that cost

// Of costs, as Worker takes it: what is left as a whole is coarse, each merge shows.
constexpr float region_slack = 1.5f;
constexpr float whole_slack = 1.1f;

constexpr double retry_share = 0.9;  // refused merges are tried again when this share of the triangles is left
constexpr std::size_t merges_per_report = 2048;

// The triangles that a region of so many positions loses.
std::size_t goal_of(std::size_t positions) {
    return static_cast<std::size_t>(2.0 * (1.0 - region_share) * static_cast<double>(positions));
}

// Progress and cancellation, from any worker.
class Monitor {
  public:
    Monitor(const RecordOptions& options, std::size_t faces) : options_(options), faces_(faces) {}

    bool cancelled() const { return cancelled_; }
    // `vanished`: faces since the last call of this worker. Returns whether to go on.
    bool report(std::size_t vanished) {
        const std::size_t total = vanished_ += vanished;
        if (!options_.progress || calling_.test_and_set()) return !cancelled_;
        const double share = static_cast<double>(total) / static_cast<double>(std::max<std::size_t>(1, faces_));
        shown_ = std::max(shown_, std::min(1.0, share));
        if (!cancelled_ && !options_.progress(shown_)) cancelled_ = true;
        calling_.clear();
        return !cancelled_;
    }

  private:
    const RecordOptions& options_;
    const std::size_t faces_;
    std::atomic<std::size_t> vanished_{0};
    std::atomic<bool> cancelled_{false};
    std::atomic_flag calling_ = ATOMIC_FLAG_INIT;
    double shown_ = 0.0;
};

class Recorder {
  public:
    Recorder(mesh::Mesh mesh, const RecordOptions& options)
        : options_(options), surface_(std::move(mesh), options.executor), monitor_(options, surface_.faces()) {
        in_region_.assign(surface_.positions(), 0);
        positions_.resize(surface_.positions());
        std::iota(positions_.begin(), positions_.end(), 0u);
    }

    Result<History> run() {
        for (std::size_t round = 0; simplify_regions(round); ++round)
            if (monitor_.cancelled()) break;
        if (!monitor_.cancelled()) simplify_whole();
        if (monitor_.cancelled()) return fail(ErrorCode::unavailable, "simplification was cancelled");
        surface_.end_merging();
        in_region_ = {};
        positions_ = {};
        return assemble(surface_, std::move(logs_), options_.executor);
    }

  private:
    void drop_dead_positions();
    bool simplify_regions(std::size_t round);
    float usual_cost();
    void simplify_region(const Regions& regions, std::size_t region, float limit, Log& log);

    void simplify_whole();
    void drop_part(Components& parts, std::uint32_t part, std::uint32_t keep, double cost);

    const RecordOptions& options_;
    Surface surface_;
    Monitor monitor_;
    std::vector<Log> logs_;
    std::vector<std::uint32_t> positions_;                              // that are left
    std::vector<std::uint8_t> in_region_;                               // of each position
    std::size_t last_faces_ = std::numeric_limits<std::size_t>::max();  // before the last round
};

void Recorder::drop_dead_positions() {
    std::erase_if(positions_, [&](std::uint32_t p) {
        bool live = false;
        surface_.sheets().for_each_sheet(p, [&](VertexHandle) { live = true; });
        return !live;
    });
    positions_.shrink_to_fit();
}

// What most edges cost at most, by a sample of them.
float Recorder::usual_cost() {
    std::vector<float> costs;
    for (std::size_t i = 0; i < positions_.size(); i += sampled_positions)
        surface_.sheets().for_each_sheet(positions_[i], [&](VertexHandle sheet) {
            costs.push_back(key_of_cost(surface_.cost(SheetMesh::edge(surface_.sheets().outgoing(sheet)))));
        });
    const auto middle =
        costs.begin() + static_cast<std::ptrdiff_t>(merged_quantile * static_cast<double>(costs.size()));
    std::nth_element(costs.begin(), middle, costs.end());
    return *middle;  // there is one: the surface has live positions
}

// Returns false where the surface is too small for that.
bool Recorder::simplify_regions(std::size_t round) {
    drop_dead_positions();
    const std::size_t faces = 2 * positions_.size();
    if (faces < min_divided_faces || static_cast<double>(faces) > max_share_left * static_cast<double>(last_faces_))
        return false;
    last_faces_ = faces;
    surface_.allow_all();
    const float limit = usual_cost();
    // An even number: two cores then end together.
    const std::size_t count = std::clamp<std::size_t>((faces / region_faces + 1) / 2 * 2, 2, max_regions);
    const Regions regions = divide(positions_, surface_.places(), count, round, options_.executor);
    // Logs get their memory here: what other threads free, this one does not get again.
    const std::size_t first_log = logs_.size();
    logs_.resize(first_log + count);
    const std::span logs = std::span(logs_).subspan(first_log);
    for (std::size_t r = 0; r < count; ++r) logs[r].reserve(goal_of(regions.in(r).size()) / 2, surface_.wedges());
    lodestream::simplify::run(options_.executor, count,
                              [&](std::size_t r) { simplify_region(regions, r, limit, logs[r]); });
    for (Log& log : logs) log.shrink();
    return true;
}

// Positions with a neighbour elsewhere stay as they are.
void Recorder::simplify_region(const Regions& regions, std::size_t region, float limit, Log& log) {
    const SheetMesh& sheets = surface_.sheets();
    std::size_t inside = 0;
    for (const std::uint32_t p : regions.in(region)) {
        bool inner = sheets.has_one_sheet(p);
        sheets.for_each_outgoing(p,
                                 [&](HalfedgeHandle h) { inner = inner && regions.of[sheets.to(h)] == regions.of[p]; });
        in_region_[p] = inner;
        inside += inner;
    }
    Worker worker(surface_, log, region_slack);
    worker.start(regions.in(region), in_region_, first_harmful_rules);
    const std::size_t goal = goal_of(inside);
    std::size_t vanished = 0, reported = 0, merges = 0;
    while (vanished < goal) {
        if (merges++ % merges_per_report == 0) {
            if (!monitor_.report(vanished - reported)) break;
            reported = vanished;
        }
        const Merge merge = worker.next();
        if (!merge.edge.is_valid() || key_of_cost(merge.cost) > limit) break;
        vanished += worker.take(merge, 3);
    }
    monitor_.report(vanished - reported);
    for (const std::uint32_t p : regions.in(region)) in_region_[p] = 0;
}

// Drops all but `keep` triangles of a part, smallest first.
void Recorder::drop_part(Components& parts, std::uint32_t part, std::uint32_t keep, double cost) {
    std::vector<std::uint32_t> faces;
    for (std::uint32_t i = parts.first_face[part]; i < parts.first_face[part + 1]; ++i)
        if (surface_.is_live(parts.faces[i])) faces.push_back(parts.faces[i]);
    parts.live[part] = keep;
    const std::size_t count = faces.size() - keep;
    surface_.drop_smallest_first(std::move(faces), count, key_of_cost(cost), logs_.back());
}

void Recorder::simplify_whole() {
    surface_.allow_all();
    Components parts = find_components(surface_);
    std::fill(in_region_.begin(), in_region_.end(), std::uint8_t{1});
    logs_.emplace_back();
    drop_dead_positions();
    logs_.back().reserve(positions_.size(), surface_.wedges());
    Worker worker(surface_, logs_.back(), whole_slack);
    worker.start(positions_, in_region_, refused);

    std::size_t live = surface_.live_faces(), next_part = 0, merges = 0, reported = live, merges_since_retry = 0;
    auto retry_below = static_cast<std::size_t>(retry_share * static_cast<double>(live));
    const auto retry = [&] {
        retry_below = static_cast<std::size_t>(retry_share * static_cast<double>(live));
        merges_since_retry = 0;
        return worker.retry_refused();
    };
    // The most visible part always stays.
    const auto drop_parts_cheaper_than = [&](double cost) {
        for (; next_part + 1 < parts.by_visibility.size(); ++next_part) {
            const std::uint32_t part = parts.by_visibility[next_part];
            if (!(parts.visibility[part] < cost)) return;
            live -= parts.live[part];
            drop_part(parts, part, 0, parts.visibility[part]);
        }
    };

    for (;;) {
        if (merges++ % merges_per_report == 0) {
            if (!monitor_.report(reported - live)) return;
            reported = live;
        }
        if (live < retry_below) retry();
        const Merge merge = worker.next();
        if (!merge.edge.is_valid()) {
            if (merges_since_retry == 0 || !retry()) break;
            continue;
        }
        drop_parts_cheaper_than(merge.cost);
        std::uint32_t& of_part = parts.live[parts.of_position[surface_.sheets().from(merge.edge)]];
        if (of_part == 0) {
            worker.skip();
            continue;
        }
        const std::size_t vanished = worker.take(merge, of_part);
        live -= vanished;
        of_part -= static_cast<std::uint32_t>(vanished);
        if (vanished > 0) ++merges_since_retry;
    }
    drop_parts_cheaper_than(std::numeric_limits<double>::infinity());
    if (next_part < parts.by_visibility.size())
        drop_part(parts, parts.by_visibility[next_part], 1, std::numeric_limits<double>::max());
}

}  // namespace

Result<History> record_history(mesh::Mesh mesh, const RecordOptions& options) {
    if (mesh.triangles.empty()) return History{};
    try {
        return Recorder(std::move(mesh), options).run();
    } catch (const std::bad_alloc&) {
        return fail(ErrorCode::limit_exceeded, "not enough memory to simplify the mesh");
    }
}

}  // namespace lodestream::simplify
