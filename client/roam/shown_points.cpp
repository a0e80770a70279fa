#include "client/roam/shown_points.h"

#include <algorithm>
#include <limits>

namespace lodestream::roam {

namespace {

double squared_distance(const Box& box, const Vec3d& point) {
    const Vec3d off = max(max(box.min - point, point - box.max), Vec3d(0.0));
    return dot(off, off);
}

bool goes_along(const Branch& branch, const Vec3d& point) {
    std::size_t nearest = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t child = 0; child < branch.children.size(); ++child) {
        const double distance = squared_distance(branch.children[child], point);
        if (!(distance < least)) continue;
        least = distance;
        nearest = child;
    }
    return nearest == branch.taken;
}

// A cloud's colours times its own base colour.
Rgba8 color_of(const codec::Points& content, std::size_t point) {
    const Vec4f color = content.cloud.colors.empty() ? Vec4f(1.0f) : Vec4f(content.cloud.colors[point]) / 255.0f;
    return Rgba8(clamp(content.base_color * color, Vec4f(0.0f), Vec4f(1.0f)) * 255.0f + 0.5f);
}

class Joined {
  public:
    explicit Joined(const std::vector<codec::Points>& contents) {
        const codec::Points& last = contents.back();
        all_.origin = last.origin;
        all_.levels = last.levels;
        all_.base_color = last.base_color;
        for (const codec::Points& content : contents) {
            is_colored_ = is_colored_ || !content.cloud.colors.empty() || content.base_color != last.base_color;
            has_normals_ = has_normals_ || !content.cloud.normals.empty();
        }
        if (is_colored_) all_.base_color = Vec4f(1.0f);
    }

    void add(const codec::Points& content, std::size_t point) {
        const points::PointCloud& cloud = content.cloud;
        all_.cloud.positions.emplace_back(Vec3d(cloud.positions[point]) + (content.origin - all_.origin));
        if (has_normals_) all_.cloud.normals.push_back(cloud.normals.empty() ? Vec3f(0.0f) : cloud.normals[point]);
        if (is_colored_) all_.cloud.colors.push_back(color_of(content, point));
    }

    codec::Points take() { return std::move(all_); }

  private:
    codec::Points all_;
    bool is_colored_ = false, has_normals_ = false;
};

}  // namespace

std::vector<std::uint32_t> path_to(std::span<const scene::LodNode> tree, std::uint32_t node) {
    std::vector<std::uint32_t> path{node};
    while (path.back() != 0) path.push_back(tree[path.back()].parent);
    std::ranges::reverse(path);
    return path;
}

std::vector<Branch> branches_of(std::span<const scene::LodNode> tree, std::span<const std::uint32_t> path) {
    std::vector<Branch> branches;
    for (std::size_t step = 0; step + 1 < path.size(); ++step) {
        const scene::LodNode& node = tree[path[step]];
        Branch& branch = branches.emplace_back();
        branch.taken = path[step + 1] - node.first_child;
        for (std::uint32_t child = 0; child < node.child_count; ++child)
            branch.children.push_back(tree[node.first_child + child].box);
    }
    return branches;
}

codec::Points shown_by(std::span<const Branch> branches, const std::vector<codec::Points>& contents) {
    Joined joined(contents);
    for (std::size_t step = 0; step < contents.size(); ++step) {
        const codec::Points& content = contents[step];
        const auto below = branches.subspan(step);
        for (std::size_t point = 0; point < content.cloud.positions.size(); ++point) {
            const Vec3d place = content.origin + Vec3d(content.cloud.positions[point]);
            if (std::ranges::all_of(below, [&](const Branch& branch) { return goes_along(branch, place); }))
                joined.add(content, point);
        }
    }
    return joined.take();
}

}  // namespace lodestream::roam
