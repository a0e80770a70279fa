#include "server/importer/gltf_nodes.h"

#include <algorithm>

#include "common/base/transform.h"

namespace lodestream::importer {
namespace {

std::string name_of(int node) {
    return "node " + std::to_string(node);
}

Result<Mat4d> local_matrix(const tinygltf::Node& node, int index) {
    const auto wrong = [](const std::vector<double>& numbers, std::size_t size) {
        return !numbers.empty() && numbers.size() != size;
    };
    if (wrong(node.matrix, 16) || wrong(node.translation, 3) || wrong(node.rotation, 4) || wrong(node.scale, 3))
        return invalid_input(name_of(index) + " has a transform of the wrong length");
    if (!node.matrix.empty()) {
        Mat4d matrix;
        for (int i = 0; i < 16; ++i) matrix[i / 4][i % 4] = node.matrix[static_cast<std::size_t>(i)];
        return matrix;
    }
    Vec3d translation{0}, scale{1};
    Vec4d rotation{0, 0, 0, 1};
    for (int i = 0; i < 3; ++i) {
        const auto at = static_cast<std::size_t>(i);
        if (!node.translation.empty()) translation[i] = node.translation[at];
        if (!node.scale.empty()) scale[i] = node.scale[at];
    }
    for (int i = 0; i < 4; ++i)
        if (!node.rotation.empty()) rotation[i] = node.rotation[static_cast<std::size_t>(i)];
    return matrix_of(translation, rotation, scale);
}

std::vector<int> root_nodes(const tinygltf::Model& json) {
    const auto& scenes = json.scenes;
    if (json.defaultScene >= 0 && static_cast<std::size_t>(json.defaultScene) < scenes.size())
        return scenes[static_cast<std::size_t>(json.defaultScene)].nodes;
    if (scenes.size() == 1) return scenes.front().nodes;
    std::vector<bool> is_child(json.nodes.size(), false);
    for (const tinygltf::Node& node : json.nodes)
        for (const int child : node.children)
            if (child >= 0 && static_cast<std::size_t>(child) < is_child.size())
                is_child[static_cast<std::size_t>(child)] = true;
    std::vector<int> roots;
    for (std::size_t i = 0; i < is_child.size(); ++i)
        if (!is_child[i]) roots.push_back(static_cast<int>(i));
    return roots;
}

class Walker {
  public:
    Walker(const GltfDocument& document, GltfAccessors& accessors, const Limits& limits)
        : json_(document.json), accessors_(accessors), limits_(limits), visited_(json_.nodes.size(), false) {
        scene_.node_to_world.resize(json_.nodes.size(), Mat4d{1.0});
    }

    Result<GltfScene> walk() {
        const std::vector<int> roots = root_nodes(json_);
        if (roots.empty() && json_.scenes.empty() && !json_.nodes.empty())
            return invalid_input("has nodes that are all children of others: a cycle");
        for (auto root = roots.rbegin(); root != roots.rend(); ++root)
            stack_.push_back({*root, 1, Mat4d{1.0}, mesh::no_parent});
        while (!stack_.empty()) {
            const Step step = stack_.back();
            stack_.pop_back();
            if (const Status visited = visit(step); !visited) return visited.error();
        }
        std::stable_sort(scene_.instances.begin(), scene_.instances.end(),
                         [](const GltfInstance& a, const GltfInstance& b) { return a.mesh < b.mesh; });
        return std::move(scene_);
    }

  private:
    struct Step {
        int node;
        std::uint32_t depth;
        Mat4d parent;
        std::uint32_t parent_place;  // in GltfScene::parents
    };

    Status visit(const Step& step) {
        if (step.node < 0 || static_cast<std::size_t>(step.node) >= json_.nodes.size())
            return invalid_input(name_of(step.node) + " does not exist");
        const auto index = static_cast<std::size_t>(step.node);
        if (visited_[index]) return invalid_input(name_of(step.node) + " is reached twice: a cycle or two parents");
        visited_[index] = true;
        if (step.depth > limits_.node_depth)
            return fail(ErrorCode::limit_exceeded,
                        name_of(step.node) + " is deeper than the limit of " + std::to_string(limits_.node_depth));
        const tinygltf::Node& node = json_.nodes[index];
        const Result<Mat4d> local = local_matrix(node, step.node);
        if (!local) return local.error();
        const Mat4d world = step.parent * *local;
        scene_.node_to_world[index] = world;
        const auto place = static_cast<std::uint32_t>(scene_.parents.size());
        scene_.parents.push_back(step.parent_place);
        for (auto child = node.children.rbegin(); child != node.children.rend(); ++child)
            stack_.push_back({*child, step.depth + 1, world, place});
        return node.mesh >= 0 ? add_instances(node, step.node, world) : Status(Nothing{});
    }

    Status add_instances(const tinygltf::Node& node, int index, const Mat4d& world) {
        if (static_cast<std::size_t>(node.mesh) >= json_.meshes.size())
            return invalid_input(name_of(index) + " names a mesh that does not exist");
        const auto extension = node.extensions.find("EXT_mesh_gpu_instancing");
        if (extension == node.extensions.end()) {
            scene_.instances.push_back({node.mesh, node.skin, world, place()});
            return Nothing{};
        }
        const Status added = add_listed_instances(extension->second, node, world);
        return added ? Status(Nothing{})
                     : Status(fail(added.error().code, name_of(index) + ": " + added.error().message));
    }

    // Of the node that is visited.
    std::uint32_t place() const { return static_cast<std::uint32_t>(scene_.parents.size() - 1); }

    // One attribute of EXT_mesh_gpu_instancing; empty where it is not given.
    Result<std::vector<float>> listed(const tinygltf::Value& attributes, const char* name, int components,
                                      std::size_t& count) {
        if (!attributes.Has(name)) return std::vector<float>{};
        Result<GltfAccessors::Floats> floats =
            accessors_.floats(attributes.Get(name).IsInt() ? attributes.Get(name).GetNumberAsInt() : -1, components,
                              components, count, name);
        if (!floats) return floats.error();
        count = floats->count;
        return std::move(floats->values);
    }

    Status add_listed_instances(const tinygltf::Value& extension, const tinygltf::Node& node, const Mat4d& world) {
        if (!extension.Has("attributes")) return invalid_input("EXT_mesh_gpu_instancing has no attributes");
        const tinygltf::Value& attributes = extension.Get("attributes");
        std::size_t count = GltfAccessors::any_count;
        const Result<std::vector<float>> translations = listed(attributes, "TRANSLATION", 3, count);
        if (!translations) return translations.error();
        const Result<std::vector<float>> rotations = listed(attributes, "ROTATION", 4, count);
        if (!rotations) return rotations.error();
        const Result<std::vector<float>> scales = listed(attributes, "SCALE", 3, count);
        if (!scales) return scales.error();
        if (count == GltfAccessors::any_count) return invalid_input("EXT_mesh_gpu_instancing has no attributes");
        if (scene_.instances.size() + count > limits_.nodes)
            return fail(ErrorCode::limit_exceeded,
                        "places more instances than the limit of " + std::to_string(limits_.nodes));
        for (std::size_t i = 0; i < count; ++i) {
            Vec3d translation{0}, scale{1};
            Vec4d rotation{0, 0, 0, 1};
            for (std::size_t k = 0; k < 3; ++k) {
                if (!translations->empty()) translation[static_cast<int>(k)] = (*translations)[3 * i + k];
                if (!scales->empty()) scale[static_cast<int>(k)] = (*scales)[3 * i + k];
            }
            for (std::size_t k = 0; k < 4; ++k)
                if (!rotations->empty()) rotation[static_cast<int>(k)] = (*rotations)[4 * i + k];
            scene_.instances.push_back(
                {node.mesh, node.skin, world * matrix_of(translation, rotation, scale), place()});
        }
        return Nothing{};
    }

    const tinygltf::Model& json_;
    GltfAccessors& accessors_;
    const Limits& limits_;
    std::vector<bool> visited_;
    std::vector<Step> stack_;
    GltfScene scene_;
};

}  // namespace

Result<GltfScene> walk_nodes(const GltfDocument& document, GltfAccessors& accessors, const Limits& limits) {
    if (document.json.nodes.size() > limits.nodes)
        return fail(ErrorCode::limit_exceeded, "has " + std::to_string(document.json.nodes.size()) +
                                                   " nodes, more than the limit of " + std::to_string(limits.nodes));
    return Walker(document, accessors, limits).walk();
}

}  // namespace lodestream::importer
