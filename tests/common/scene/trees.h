// Seeded trees of levels and views of them.
#pragma once

#include <algorithm>
#include <vector>

#include "common/base/random.h"
#include "common/scene/lod_tree.h"
#include "common/scene/view.h"

namespace lodestream::scene::testing {

// Boxes divided along their longest axis, errors and triangles as simplification makes them: the error is the area over
// the triangles, and a child shows its share of the area with as many triangles as its parent, or, alone, all of it
// with three times as many. A branch ends early now and then.
inline LodTree made_tree(std::size_t nodes, Random& random, double size = 100.0, const Vec3d& origin = Vec3d{0.0},
                         double early_ends = 0.1) {
    LodTree tree(1);
    tree[0].box = {origin, origin + Vec3d{size, 0.4 * size, 0.6 * size}};
    tree[0].error = 0.1 * size;
    tree[0].triangles = 1'000;
    for (std::uint32_t i = 0; i < tree.size() && tree.size() + 4 <= nodes; ++i) {
        if (i > 0 && random.uniform() < early_ends && i + 1 < tree.size()) continue;
        const std::uint32_t count = random.uniform() < 0.7 ? 2 : random.uniform() < 0.5 ? 1 : 4;
        tree[i].first_child = static_cast<std::uint32_t>(tree.size());
        tree[i].child_count = count;
        const LodNode parent = tree[i];
        const Vec3d extent = parent.box.extent();
        int axis = extent.y > extent.x ? 1 : 0;
        if (extent.z > extent[axis]) axis = 2;
        for (std::uint32_t k = 0; k < count; ++k) {
            LodNode child;
            child.parent = i;
            child.box = parent.box;
            child.box.min[axis] = parent.box.min[axis] + extent[axis] * k / count;
            child.box.max[axis] = std::min(parent.box.max[axis], parent.box.min[axis] + extent[axis] * (k + 1) / count);
            child.error = parent.error * std::min(1.0, random.uniform(0.7, 1.3) / (count == 1 ? 3 : count));
            child.triangles = static_cast<std::uint64_t>(random.uniform(600, 1'400)) * (count == 1 ? 3 : 1);
            tree.push_back(child);
        }
    }
    for (LodNode& node : tree)
        if (node.child_count == 0) node.error = 0.0;
    return tree;
}

inline View made_view(Random& random, const Box& box) {
    const auto inside = [&](double margin) {
        const Vec3d extent = box.extent();
        return box.min - extent * margin +
               extent * (1.0 + 2.0 * margin) * Vec3d{random.uniform(), random.uniform(), random.uniform()};
    };
    View view;
    view.eye = inside(random.uniform() < 0.3 ? 0.0 : 2.0);
    view.target = inside(0.0);
    view.fov_y_deg = random.uniform(20.0, 100.0);
    view.width = static_cast<std::uint32_t>(random.uniform(100, 3'000));
    view.height = static_cast<std::uint32_t>(random.uniform(100, 2'000));
    view.near = box.diagonal() * random.log_uniform(1e-5, 1e-2);
    return view;
}

// Whether exactly one of `nodes` lies at or above each leaf, and none below a leaf's own.
inline bool covers_each_leaf_once(const LodTree& tree, const std::vector<std::uint32_t>& nodes) {
    std::vector<int> above(tree.size(), 0);
    for (const std::uint32_t node : nodes) ++above[node];
    for (std::size_t i = 1; i < tree.size(); ++i) above[i] += above[tree[i].parent];
    for (std::size_t i = 0; i < tree.size(); ++i)
        if (tree[i].child_count == 0 && above[i] != 1) return false;
    return true;
}

inline std::uint64_t triangles_seen(const LodTree& tree, const std::vector<std::uint32_t>& nodes, const View& view) {
    const Projection projection(view);
    std::uint64_t triangles = 0;
    for (const std::uint32_t node : nodes)
        if (projection.sees(tree[node].box)) triangles += tree[node].triangles;
    return triangles;
}

}  // namespace lodestream::scene::testing
