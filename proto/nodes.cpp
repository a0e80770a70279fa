#include "proto/nodes.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "common/base/transform.h"
#include "proto/json_reader.h"

namespace lodestream::proto {

namespace {

using Object = nlohmann::ordered_json;

constexpr std::array<const char*, 3> parts{"translation", "rotation", "scale"};

Mat4d matrix_from(const std::array<double, 16>& numbers) {
    Mat4d matrix;
    for (int i = 0; i < 16; ++i) matrix[i / 4][i % 4] = numbers[static_cast<std::size_t>(i)];
    return matrix;
}

std::array<double, 16> numbers_of(const Mat4d& matrix) {
    std::array<double, 16> numbers{};
    for (int i = 0; i < 16; ++i) numbers[static_cast<std::size_t>(i)] = matrix[i / 4][i % 4];
    return numbers;
}

std::optional<Mat4d> read_matrix(const Fields& fields) {
    const bool has_parts = std::any_of(parts.begin(), parts.end(), [&](const char* part) { return fields.has(part); });
    if (fields.has("matrix")) {
        if (has_parts) fields.refuse("matrix", "must not be beside translation, rotation or scale");
        std::array<double, 16> numbers{};
        fields.read("matrix", numbers);
        return matrix_from(numbers);
    }
    if (!has_parts) return std::nullopt;
    Vec3d translation{0.0}, scale{1.0};
    std::array<double, 4> rotation{0.0, 0.0, 0.0, 1.0};
    fields.read("translation", translation);
    fields.read("rotation", rotation);
    fields.read("scale", scale);
    const Vec4d quaternion{rotation[0], rotation[1], rotation[2], rotation[3]};
    const double size = length(quaternion);
    if (!(size > 0.0) || !std::isfinite(size)) fields.refuse("rotation", "must be a quaternion of some length");
    return matrix_of(translation, quaternion, scale);
}

NodeChange read_change(const Fields& fields) {
    NodeChange change;
    fields.read("parent", change.parent);
    if (!change.parent || fields.has("node")) fields.require("node", change.node);
    if (change.parent == next_node) fields.refuse("parent", "must be a node");
    if (!change.parent && change.node == next_node) fields.refuse("node", "must be a node");
    change.matrix = read_matrix(fields);
    fields.read("visible", change.visible);
    fields.read("asset", change.asset);
    if (change.asset && change.asset->size() > max_asset_name)
        fields.refuse("asset", "must have at most " + std::to_string(max_asset_name) + " bytes");
    if (!change.matrix && !change.visible && !change.asset)
        fields.refuse("matrix", "or a part of it, visible or asset must be given");
    if (change.matrix)
        if (const Status valid = scene::validate({*change.matrix, true}); !valid)
            fields.refuse("matrix", valid.error().message);
    return change;
}

// Empty boxes have no members.
void write_box(Object& object, const Box& box) {
    if (box.empty()) return;
    object["bounds_min"] = {box.min.x, box.min.y, box.min.z};
    object["bounds_max"] = {box.max.x, box.max.y, box.max.z};
}

SceneNode read_node(const Fields& fields) {
    SceneNode node;
    fields.require("node", node.node);
    fields.read("parent", node.parent);
    fields.read("objects", node.objects);
    if (fields.has("bounds_min")) {
        fields.read("bounds_min", node.bounds.min);
        fields.require("bounds_max", node.bounds.max);
    }
    std::array<double, 16> numbers = numbers_of(Mat4d(1.0));
    fields.read("matrix", numbers);
    fields.read("visible", node.placement.visible);
    node.placement.matrix = matrix_from(numbers);
    fields.read("asset", node.asset);
    return node;
}

}  // namespace

Result<std::vector<NodeChange>> parse_node_changes(std::string_view text) {
    const Result<Json> json = parse_json(text);
    if (!json) return json.error();
    std::optional<Error> error;
    const Fields fields(*json, "", error);
    if (!error && !fields.has("nodes")) fields.refuse("nodes", "is missing");
    const std::vector<Fields> objects = error ? std::vector<Fields>{} : fields.objects("nodes");
    if (objects.size() > max_node_changes)
        return fail(ErrorCode::limit_exceeded,
                    "nodes has more than " + std::to_string(max_node_changes) + " entries, send them in parts");
    std::vector<NodeChange> changes;
    std::set<std::uint32_t> seen;
    for (const Fields& object : objects) {
        changes.push_back(read_change(object));
        const std::uint32_t node = changes.back().node;
        if (!error && node != next_node && !seen.insert(node).second) object.refuse("node", "is there twice");
        if (error) return *error;
    }
    if (error) return *error;
    if (changes.empty()) return invalid_input("nodes must not be empty");
    return changes;
}

std::string to_json(const std::vector<NodeChange>& changes) {
    Object list = Object::array();
    for (const NodeChange& change : changes) {
        Object object = Object::object();
        if (change.node != next_node) object["node"] = change.node;
        if (change.parent) object["parent"] = *change.parent;
        if (change.asset) object["asset"] = *change.asset;
        if (change.matrix) object["matrix"] = numbers_of(*change.matrix);
        if (change.visible) object["visible"] = *change.visible;
        list.push_back(std::move(object));
    }
    return Object{{"nodes", std::move(list)}}.dump();
}

Result<NodesChanged> parse_nodes_changed(std::string_view text) {
    const Result<Json> json = parse_json(text);
    if (!json) return json.error();
    std::optional<Error> error;
    const Fields fields(*json, "", error);
    NodesChanged changed;
    fields.require("revision", changed.revision);
    fields.require("moved_objects", changed.moved_objects);
    fields.read("added", changed.added);
    if (error) return *error;
    return changed;
}

std::string to_json(const NodesChanged& changed) {
    Object object{{"revision", changed.revision}, {"moved_objects", changed.moved_objects}};
    if (!changed.added.empty()) object["added"] = changed.added;
    return object.dump();
}

Result<SceneNodes> parse_scene_nodes(std::string_view text) {
    const Result<Json> json = parse_json(text);
    if (!json) return json.error();
    std::optional<Error> error;
    const Fields fields(*json, "", error);
    SceneNodes nodes;
    fields.require("revision", nodes.revision);
    fields.require("count", nodes.count);
    for (const Fields& object : fields.objects("nodes")) nodes.nodes.push_back(read_node(object));
    if (error) return *error;
    return nodes;
}

std::string to_json(const SceneNodes& nodes) {
    Object list = Object::array();
    for (const SceneNode& node : nodes.nodes) {
        Object object{{"node", node.node}, {"parent", node.parent ? Object(*node.parent) : Object(nullptr)}};
        object["objects"] = node.objects;
        write_box(object, node.bounds);
        object["matrix"] = numbers_of(node.placement.matrix);
        object["visible"] = node.placement.visible;
        if (!node.asset.empty()) object["asset"] = node.asset;
        list.push_back(std::move(object));
    }
    return Object{{"revision", nodes.revision}, {"count", nodes.count}, {"nodes", std::move(list)}}.dump();
}

}  // namespace lodestream::proto
