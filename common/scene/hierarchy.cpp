#include "common/scene/hierarchy.h"

#include <algorithm>
#include <cassert>
#include <numeric>
#include <utility>

namespace lodestream::scene {

namespace {

constexpr double max_child_share = 7.0 / 8.0;  // of its parent's objects

// A run of the object order. `graph_node` is whose whole branch it is; none: of no one's.
struct Part {
    std::uint32_t begin = 0, end = 0;
    std::uint32_t graph_node = none;

    std::uint32_t size() const { return end - begin; }
};

// The scene graph with its objects in an order in which those of every branch are one run.
struct Branches {
    std::vector<std::uint32_t> objects;      // first those of the node itself, then those of its children's branches
    std::vector<Part> runs;                  // of each node
    std::vector<std::uint32_t> own_counts;   // objects of the node itself
    std::vector<std::uint32_t> children;     // of all nodes, each node's side by side
    std::vector<std::uint32_t> first_child;  // of each node, and the end

    std::span<const std::uint32_t> children_of(std::uint32_t node) const {
        return std::span(children).subspan(first_child[node], first_child[node + 1] - first_child[node]);
    }
};

void list_children(Branches& branches, std::span<const std::uint32_t> parents) {
    branches.first_child.assign(parents.size() + 1, 0);
    for (const std::uint32_t parent : parents)
        if (parent != none) ++branches.first_child[parent + 1];
    std::partial_sum(branches.first_child.begin(), branches.first_child.end(), branches.first_child.begin());
    branches.children.resize(branches.first_child.back());
    std::vector<std::uint32_t> next(branches.first_child.begin(), branches.first_child.end() - 1);
    for (std::uint32_t node = 0; node < parents.size(); ++node)
        if (parents[node] != none) branches.children[next[parents[node]]++] = node;
}

Branches order_by_branch(std::span<const Object> objects, std::span<const std::uint32_t> parents) {
    const std::size_t count = parents.size();
    Branches branches;
    branches.own_counts.assign(count, 0);
    for (const Object& object : objects)
        if (object.triangles > 0) ++branches.own_counts[object.graph_node];
    std::vector<std::uint32_t> sizes = branches.own_counts;
    for (std::size_t node = count; node-- > 0;)
        if (parents[node] != none) sizes[parents[node]] += sizes[node];

    branches.runs.resize(count);
    std::uint32_t next_root = 0;
    std::vector<std::uint32_t> next(count);  // where the node's next child's branch begins
    for (std::uint32_t node = 0; node < count; ++node) {
        std::uint32_t& begin = parents[node] == none ? next_root : next[parents[node]];
        branches.runs[node] = {begin, begin + sizes[node], node};
        next[node] = begin + branches.own_counts[node];
        begin += sizes[node];
    }
    list_children(branches, parents);

    branches.objects.resize(next_root);
    std::vector<std::uint32_t> place(count);
    for (std::size_t node = 0; node < count; ++node) place[node] = branches.runs[node].begin;
    for (std::uint32_t i = 0; i < objects.size(); ++i)
        if (objects[i].triangles > 0) branches.objects[place[objects[i].graph_node]++] = i;
    return branches;
}

class Builder {
  public:
    Builder(std::span<const Object> objects, std::span<const std::uint32_t> parents, const HierarchyOptions& options)
        : objects_(objects), options_(options), branches_(order_by_branch(objects, parents)) {
        order_.swap(branches_.objects);
        for (std::uint32_t node = 0; node < parents.size(); ++node)
            if (parents[node] == none && branches_.runs[node].size() > 0) roots_.push_back(branches_.runs[node]);
    }

    Hierarchy build() {
        if (order_.empty()) return {};
        const Part all{0, static_cast<std::uint32_t>(order_.size()), none};
        add(roots_.size() == 1 ? roots_.front() : all, none);
        for (std::uint32_t node = 0; node < parts_.size(); ++node) divide(node);
        return {std::move(nodes_), std::move(order_)};
    }

  private:
    const Object& object(std::uint32_t place) const { return objects_[order_[place]]; }

    void add(const Part& part, std::uint32_t parent) {
        HierarchyNode node;
        node.parent = parent;
        node.first_object = part.begin;
        node.object_count = part.size();
        for (std::uint32_t i = part.begin; i < part.end; ++i) {
            node.box.add(object(i).box.min);
            node.box.add(object(i).box.max);
            node.triangles += object(i).triangles;
        }
        nodes_.push_back(node);
        parts_.push_back(part);
    }

    void divide(std::uint32_t index) {
        const HierarchyNode node = nodes_[index];
        if (node.object_count == 1 || node.triangles <= options_.leaf_triangles) return;
        const Part part = parts_[index];
        const std::vector<Part> graph_parts = index == 0 && roots_.size() > 1 ? opened(roots_) : graph_division(part);
        // The division of space reorders the objects, which a graph's division needs as they were.
        const std::vector<std::uint32_t> before(order_.begin() + part.begin, order_.begin() + part.end);
        const bool balanced = is_balanced(graph_parts, part);
        const double graph_cost = balanced ? cost(graph_parts) : 0.0;
        std::vector<Part> parts = space_division(part);
        if (balanced && graph_cost <= options_.graph_tolerance * cost(parts)) {
            std::copy(before.begin(), before.end(), order_.begin() + part.begin);
            parts = graph_parts;
        }
        std::sort(parts.begin(), parts.end(), [](const Part& a, const Part& b) { return a.begin < b.begin; });
        nodes_[index].first_child = static_cast<std::uint32_t>(nodes_.size());
        nodes_[index].child_count = static_cast<std::uint32_t>(parts.size());
        for (const Part& child : parts) add(child, index);
    }

    std::vector<Part> graph_division(const Part& part) const {
        return part.graph_node == none ? std::vector<Part>{} : opened({part});
    }

    // Opens the largest branch as long as it outweighs the rest together and that does not make too many parts.
    std::vector<Part> opened(std::vector<Part> parts) const {
        const std::uint32_t all = std::accumulate(parts.begin(), parts.end(), 0u,
                                                  [](std::uint32_t n, const Part& p) { return n + p.size(); });
        while (!parts.empty() && parts.size() <= options_.max_children) {
            const auto largest = std::max_element(parts.begin(), parts.end(),
                                                  [](const Part& a, const Part& b) { return a.size() < b.size(); });
            if (largest->graph_node == none || 2 * std::uint64_t{largest->size()} <= all) break;
            std::vector<Part> more = parts;
            if (!open(more, static_cast<std::size_t>(largest - parts.begin()))) break;
            parts = std::move(more);
        }
        return parts;
    }

    // Puts a branch's own objects and its children's branches in its place; false where those are too many.
    bool open(std::vector<Part>& parts, std::size_t which) const {
        const Part branch = parts[which];
        parts.erase(parts.begin() + static_cast<std::ptrdiff_t>(which));
        const std::uint32_t own = branches_.own_counts[branch.graph_node];
        if (own > options_.max_children) return false;
        for (std::uint32_t i = 0; i < own; ++i) parts.push_back({branch.begin + i, branch.begin + i + 1, none});
        for (const std::uint32_t child : branches_.children_of(branch.graph_node)) {
            if (branches_.runs[child].size() > 0) parts.push_back(branches_.runs[child]);
            if (parts.size() > options_.max_children) return false;
        }
        return true;
    }

    bool is_balanced(const std::vector<Part>& parts, const Part& whole) const {
        return parts.size() >= 2 && parts.size() <= options_.max_children &&
               std::all_of(parts.begin(), parts.end(),
                           [&](const Part& part) { return part.size() <= max_child_share * whole.size(); });
    }

    // Triangles times the size of what they are drawn with: what a view that needs one place is made to draw.
    double cost(const std::vector<Part>& parts) const {
        double sum = 0.0;
        for (const Part& part : parts) {
            Box box;
            double triangles = 0.0;
            for (std::uint32_t i = part.begin; i < part.end; ++i) {
                box.add(object(i).box.min);
                box.add(object(i).box.max);
                triangles += static_cast<double>(object(i).triangles);
            }
            sum += triangles * box.diagonal();
        }
        return sum;
    }

    std::vector<Part> space_division(const Part& whole) {
        std::vector<Part> parts{{whole.begin, whole.end, none}};
        while (parts.size() < options_.max_children) {
            const auto largest = std::max_element(parts.begin(), parts.end(),
                                                  [&](const Part& a, const Part& b) { return weight(a) < weight(b); });
            if (largest->size() < 2 || (parts.size() >= 2 && weight(*largest) <= options_.leaf_triangles)) break;
            const std::uint32_t middle = halve(*largest);
            const std::uint32_t end = std::exchange(largest->end, middle);
            parts.push_back({middle, end, none});
        }
        return parts;
    }

    // Of a part that can still be halved.
    std::uint64_t weight(const Part& part) const {
        if (part.size() < 2) return 0;
        std::uint64_t triangles = 0;
        for (std::uint32_t i = part.begin; i < part.end; ++i) triangles += object(i).triangles;
        return triangles;
    }

    // Sorts the part along the longest axis of its objects' middles and returns the place where half of its triangles
    // lie on either side, but at least an eighth of its objects: a heavy object must not make the tree a chain.
    std::uint32_t halve(const Part& part) {
        Box middles;
        for (std::uint32_t i = part.begin; i < part.end; ++i) middles.add(object(i).box.center());
        const Vec3d extent = middles.extent();
        int axis = 0;
        for (const int other : {1, 2})
            if (extent[other] > extent[axis]) axis = other;
        std::sort(order_.begin() + part.begin, order_.begin() + part.end, [&](std::uint32_t a, std::uint32_t b) {
            const double x = objects_[a].box.center()[axis], y = objects_[b].box.center()[axis];
            return x != y ? x < y : a < b;
        });
        const std::uint64_t all = weight(part);
        std::uint64_t left = 0;
        std::uint32_t middle = part.begin;
        while (middle < part.end && 2 * left < all) left += object(middle++).triangles;
        const std::uint32_t least = std::max(1u, part.size() / 8 + (part.size() % 8 > 0 ? 1 : 0));
        return std::clamp(middle, part.begin + least, part.end - least);
    }

    std::span<const Object> objects_;
    HierarchyOptions options_;
    Branches branches_;
    std::vector<std::uint32_t> order_;
    std::vector<Part> roots_;
    std::vector<Part> parts_;  // of each node
    std::vector<HierarchyNode> nodes_;
};

}  // namespace

Hierarchy build_hierarchy(std::span<const Object> objects, std::span<const std::uint32_t> graph_parents,
                          const HierarchyOptions& options) {
    assert(options.max_children >= 2);
    if (!graph_parents.empty()) return Builder(objects, graph_parents, options).build();
    const std::uint32_t one_node = none;
    std::vector<Object> flat(objects.begin(), objects.end());
    for (Object& object : flat) object.graph_node = 0;
    return Builder(flat, std::span(&one_node, 1), options).build();
}

}  // namespace lodestream::scene
