#include "common/scene/stream.h"

#include <algorithm>
#include <cassert>
#include <queue>

namespace lodestream::scene {

namespace {

struct Candidate {
    double error_px;
    std::uint32_t node;
    bool operator<(const Candidate& other) const {
        return error_px != other.error_px ? error_px < other.error_px : node > other.node;
    }
};

// The nodes that views refine, view after view and in the order of their error, as far as their children fit into the
// memory.
struct Wanted {
    std::vector<std::uint32_t> refined;
    std::vector<bool> is_refined;  // of each node
    std::uint64_t bytes = 0;       // of the root and of all children of `refined`
};

template <class Visit>
void for_each_child(std::span<const LodNode> tree, std::uint32_t node, Visit visit) {
    for (std::uint32_t k = 0; k < tree[node].child_count; ++k) visit(tree[node].first_child + k);
}

std::uint64_t bytes_of_children(std::span<const LodNode> tree, const Residency& residency, std::uint32_t node) {
    std::uint64_t bytes = 0;
    for_each_child(tree, node, [&](std::uint32_t child) { bytes += residency.bytes[child]; });
    return bytes;
}

// Returns whether memory and triangles have room for all that the view refines.
bool add_view(std::span<const LodNode> tree, const Residency& residency, const View& view, const StreamOptions& options,
              Wanted& wanted) {
    const Projection projection(view);
    const auto seen_triangles = [&](std::uint32_t node) {
        return projection.sees(tree[node].box) ? tree[node].triangles : 0;
    };
    bool fits = true;
    std::uint64_t triangles = seen_triangles(0);
    std::priority_queue<Candidate> open;
    const auto add = [&](std::uint32_t node) {
        if (tree[node].child_count == 0 || residency.is_end[node]) return;
        const double error_px = projection.error_px(tree[node].box, tree[node].error);
        if (error_px > options.tolerance_px) open.push({error_px, node});
    };
    add(0);
    while (!open.empty()) {
        const std::uint32_t node = open.top().node;
        open.pop();
        std::uint64_t refined_triangles = triangles - seen_triangles(node);
        for_each_child(tree, node, [&](std::uint32_t child) { refined_triangles += seen_triangles(child); });
        if (refined_triangles > options.max_triangles) {
            fits = false;
            continue;
        }
        if (!wanted.is_refined[node]) {
            const std::uint64_t more = bytes_of_children(tree, residency, node);
            if (wanted.bytes + more > options.max_bytes) {
                fits = false;
                continue;
            }
            wanted.bytes += more;
            wanted.refined.push_back(node);
            wanted.is_refined[node] = true;
        }
        triangles = refined_triangles;
        for_each_child(tree, node, add);
    }
    return fits;
}

// What is shown keeps what is above it.
void mark_used(std::span<const LodNode> tree, Residency& residency, const Wanted& wanted,
               std::span<const std::uint32_t> shown) {
    const auto use = [&](std::uint32_t node) {
        if (residency.has(node)) residency.last_used[node] = residency.frame;
    };
    use(0);
    for (const std::uint32_t node : wanted.refined) for_each_child(tree, node, use);
    for (std::uint32_t node : shown)
        for (; residency.has(node) && residency.last_used[node] < residency.frame; node = tree[node].parent) use(node);
}

std::size_t count_missing(std::span<const LodNode> tree, const Residency& residency, const Wanted& wanted) {
    std::size_t missing = residency.has(0) ? 0 : 1;
    for (const std::uint32_t node : wanted.refined)
        for_each_child(tree, node, [&](std::uint32_t child) { missing += residency.has(child) ? 0 : 1; });
    return missing;
}

// From the root down as far as it is wanted and all children are here.
std::vector<std::uint32_t> drawn_now(std::span<const LodNode> tree, const Residency& residency,
                                     const std::vector<bool>& is_refined) {
    std::vector<std::uint32_t> drawn, stack;
    if (residency.has(0)) stack.push_back(0);
    while (!stack.empty()) {
        const std::uint32_t node = stack.back();
        stack.pop_back();
        bool whole = is_refined[node];
        for_each_child(tree, node, [&](std::uint32_t child) { whole = whole && residency.has(child); });
        if (whole)
            for_each_child(tree, node, [&](std::uint32_t child) { stack.push_back(child); });
        else
            drawn.push_back(node);
    }
    return drawn;
}

// Wanted nodes that are not here; parents are refined before their children.
std::vector<std::uint32_t> next_requests(std::span<const LodNode> tree, const Residency& residency,
                                         const Wanted& wanted, std::size_t most) {
    std::vector<std::uint32_t> requests;
    if (!residency.has(0)) requests.push_back(0);
    for (const std::uint32_t node : wanted.refined) {
        for_each_child(tree, node, [&](std::uint32_t child) {
            if (!residency.has(child) && requests.size() < most) requests.push_back(child);
        });
        if (requests.size() >= most) break;
    }
    return requests;
}

void drop(Residency& residency, std::uint32_t node) {
    residency.last_used[node] = 0;
    residency.held_bytes -= residency.bytes[node];
}

// Drops what is not wanted, least recently used first and children before their parents, until `bytes` more fit.
std::vector<std::uint32_t> make_room(std::span<const LodNode> tree, Residency& residency, std::uint64_t bytes,
                                     std::uint64_t max_bytes) {
    std::vector<std::uint32_t> dropped;
    if (residency.held_bytes + bytes <= max_bytes) return dropped;
    std::vector<std::uint32_t> idle;
    for (std::uint32_t node = 1; node < tree.size(); ++node)
        if (residency.has(node) && residency.last_used[node] < residency.frame) idle.push_back(node);
    // A parent is used whenever its children are, and has the lower index.
    std::sort(idle.begin(), idle.end(), [&](std::uint32_t a, std::uint32_t b) {
        return residency.last_used[a] != residency.last_used[b] ? residency.last_used[a] < residency.last_used[b]
                                                                : a > b;
    });
    for (const std::uint32_t node : idle) {
        if (residency.held_bytes + bytes <= max_bytes) break;
        drop(residency, node);
        dropped.push_back(node);
    }
    return dropped;
}

// Leaves out the last requests where what cannot be dropped yet takes their room. A root needs none.
void keep_to_room(const Residency& residency, std::uint64_t max_bytes, std::vector<std::uint32_t>& requests) {
    std::uint64_t bytes = residency.held_bytes;
    const auto fits = [&](std::uint32_t node) {
        bytes += residency.bytes[node];
        return node == 0 || bytes <= max_bytes;
    };
    requests.erase(std::find_if_not(requests.begin(), requests.end(), fits), requests.end());
}

}  // namespace

StreamStep step(std::span<const LodNode> tree, Residency& residency, const View& view, const StreamOptions& options,
                std::span<const View> coming, std::span<const std::uint32_t> shown) {
    assert(!tree.empty() && residency.bytes.size() == tree.size());
    ++residency.frame;
    Wanted wanted{{}, std::vector<bool>(tree.size(), false), residency.bytes[0]};
    StreamStep result;
    result.bounded = !add_view(tree, residency, view, options, wanted);
    result.missing = count_missing(tree, residency, wanted);
    const std::vector<bool> refined_now = wanted.is_refined;
    for (const View& later : coming) add_view(tree, residency, later, options, wanted);
    result.requests = next_requests(tree, residency, wanted, options.max_requests);

    mark_used(tree, residency, wanted, shown);
    std::uint64_t bytes = 0;
    for (const std::uint32_t node : result.requests) bytes += residency.bytes[node];
    result.dropped = make_room(tree, residency, bytes, options.max_bytes);
    keep_to_room(residency, options.max_bytes, result.requests);
    for (const std::uint32_t node : result.requests)
        if (node != 0 && !refined_now[tree[node].parent]) ++result.ahead;
    result.drawn = drawn_now(tree, residency, refined_now);
    return result;
}

bool arrive(std::span<const LodNode> tree, Residency& residency, std::uint32_t node, const StreamOptions& options) {
    if (residency.has(node)) return true;
    const bool has_parent = node == 0 || residency.has(tree[node].parent);
    const bool fits = node == 0 || residency.held_bytes + residency.bytes[node] <= options.max_bytes;
    if (!has_parent || !fits) return false;
    // Not later than its parent, which must not be dropped before it.
    residency.last_used[node] =
        node == 0 ? std::max<std::uint64_t>(residency.frame, 1) : residency.last_used[tree[node].parent];
    residency.held_bytes += residency.bytes[node];
    return true;
}

void give_up(std::span<const LodNode> tree, Residency& residency, std::uint32_t node) {
    if (node != 0) residency.is_end[tree[node].parent] = true;
}

}  // namespace lodestream::scene
