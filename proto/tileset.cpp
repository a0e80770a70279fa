#include "proto/tileset.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "common/scene/placement.h"
#include "proto/json_reader.h"

namespace lodestream::proto {

namespace {

constexpr double root_error_factor =
    2.0;  // of not drawing the model at all, over its coarsest level's; at least the diagonal

constexpr double right_angle_slack = 1e-9;

// JSON knows no infinity.
std::string number(double value) {
    constexpr double most = std::numeric_limits<double>::max();
    std::array<char, 32> text{};
    const auto end = std::to_chars(text.data(), text.data() + text.size(), std::clamp(value, -most, most)).ptr;
    return {text.data(), end};
}

std::string quoted(const std::string& text) {
    std::string result = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') result += '\\';
        if (static_cast<unsigned char>(c) >= 0x20) result += c;
    }
    return result + '"';
}

template <std::size_t Count>
std::string numbers_json(const std::array<double, Count>& numbers) {
    std::string text = "[";
    for (std::size_t i = 0; i < Count; ++i) text += (i > 0 ? "," : "") + number(numbers[i] + 0.0);
    return text + "]";
}

// Between the axes of glTF, y up, and those of tiles, z up: (x, y, z) becomes (x, -z, y).
const Mat4d to_z_up{1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1};

std::array<double, 16> numbers_of(const Mat4d& matrix) {
    std::array<double, 16> numbers{};
    for (int i = 0; i < 16; ++i) numbers[static_cast<std::size_t>(i)] = matrix[i / 4][i % 4];
    return numbers;
}

// What a viewer of tiles takes a geometric error times for a tile's transform.
double error_scale(const Mat4d& matrix) {
    return std::max({length(Vec3d(matrix[0])), length(Vec3d(matrix[1])), length(Vec3d(matrix[2]))});
}

// A box with axes of its own.
struct OrientedBox {
    Vec3d center, x, y, z;  // half axes
};

OrientedBox oriented(const Box& box) {
    const Vec3d half = box.max / 2.0 - box.min / 2.0;
    return {box.min + half, {half.x, 0, 0}, {0, half.y, 0}, {0, 0, half.z}};
}

OrientedBox moved(const OrientedBox& box, const Mat4d& matrix) {
    const Mat3d linear(matrix);
    return {Vec3d(matrix * Vec4d(box.center, 1.0)), linear * box.x, linear * box.y, linear * box.z};
}

Box box_around(const OrientedBox& box) {
    const Vec3d half = glm::abs(box.x) + glm::abs(box.y) + glm::abs(box.z);
    return {box.center - half, box.center + half};
}

// Whether its axes are at right angles, as viewers expect.
bool is_right(const OrientedBox& box) {
    const auto right = [](const Vec3d& a, const Vec3d& b) {
        return std::abs(dot(a, b)) <= right_angle_slack * length(a) * length(b);
    };
    return right(box.x, box.y) && right(box.y, box.z) && right(box.z, box.x);
}

// Centre and half axes, turned from y up to z up; the order of the axes is that of z up.
std::string box_json(const Box& world, const Mat4d& matrix) {
    OrientedBox box = oriented(world);
    if (matrix != Mat4d(1.0)) box = moved(box, inverse(matrix));
    if (!is_right(box)) box = oriented(box_around(box));
    const auto [c, x, y, z] = box;
    return "{\"box\":" + numbers_json(std::array{c.x, -c.z, c.y, x.x, -x.z, x.y, -z.x, z.z, -z.y, y.x, -y.z, y.y}) +
           "}";
}

// Against the tile above, whose own is in force below it.
std::string transform_json(const Tileset& tileset, std::size_t i) {
    const std::uint32_t parent = tileset.nodes[i].parent;
    const Mat4d above = parent == scene::none ? Mat4d(1.0) : tileset.matrix(parent), own = tileset.matrix(i);
    if (own == above) return "";
    return "\"transform\":" + numbers_json(numbers_of(to_z_up * inverse(above) * own * inverse(to_z_up))) + ",";
}

// All of a tile but its children and what closes it.
std::string opened_tile(const Tileset& tileset, std::size_t i) {
    const scene::LodNode& tile = tileset.nodes[i];
    const Mat4d matrix = tileset.matrix(i);
    const std::uint32_t node = tileset.scene_nodes.empty() ? no_scene_node : tileset.scene_nodes[i];
    return "{" + transform_json(tileset, i) + "\"boundingVolume\":" + box_json(tile.box, matrix) +
           ",\"geometricError\":" + number(tile.error / error_scale(matrix)) +
           ",\"content\":{\"uri\":" + quoted(tileset.uris[i]) +
           "},\"extras\":{\"triangles\":" + std::to_string(tile.triangles) +
           ",\"bytes\":" + std::to_string(tileset.bytes[i]) +
           (node == no_scene_node ? "" : ",\"node\":" + std::to_string(node)) +
           (tileset.ids.empty() ? "" : ",\"id\":" + std::to_string(tileset.ids[i])) + "}";
}

double root_error(const scene::LodNode& root) {
    const Vec3d half = root.box.max / 2.0 - root.box.min / 2.0;
    return std::max(2.0 * std::hypot(half.x, half.y, half.z), root_error_factor * root.error);
}

std::optional<std::array<double, 16>> sixteen_numbers(const Json& json) {
    std::array<double, 16> numbers{};
    if (!json.is_array() || json.size() != numbers.size()) return std::nullopt;
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        if (!json[i].is_number()) return std::nullopt;
        numbers[i] = json[i].get<double>();
    }
    return numbers;
}

// Turned from z up to y up.
Result<Mat4d> read_transform(const Json& tile) {
    const auto found = tile.find("transform");
    if (found == tile.end()) return Mat4d(1.0);
    const auto numbers = sixteen_numbers(*found);
    if (!numbers) return invalid_input("its transform is not sixteen numbers");
    Mat4d matrix;
    for (int i = 0; i < 16; ++i) matrix[i / 4][i % 4] = (*numbers)[static_cast<std::size_t>(i)];
    return inverse(to_z_up) * matrix * to_z_up;
}

// A box's centre and three half axes, turned from z up to y up and put where `matrix` says; as the box around it.
Result<Box> read_box(const Json& volume, const Mat4d& matrix) {
    const auto numbers = volume.is_object() ? volume.find("box") : volume.end();
    if (!volume.is_object() || numbers == volume.end())
        return fail(ErrorCode::unsupported, "its bounding volume is no box");
    if (!numbers->is_array() || numbers->size() != 12 ||
        !std::all_of(numbers->begin(), numbers->end(), [](const Json& n) { return n.is_number(); }))
        return invalid_input("its box is not twelve numbers");
    std::array<Vec3d, 4> v;
    for (std::size_t k = 0; k < 4; ++k) {
        const auto at = [&](std::size_t i) { return (*numbers)[3 * k + i].get<double>(); };
        v[k] = {at(0), at(2), -at(1)};
    }
    const Box box = box_around(moved({v[0], v[1], v[2], v[3]}, matrix));
    if (!all_finite(box.min) || !all_finite(box.max)) return invalid_input("its box is not finite");
    return box;
}

// Into the node at `i`, which is there, and its content behind those before.
Status read_tile(const Json& tile, Tileset& tileset, std::size_t i) {
    if (!tile.is_object()) return invalid_input("is no object");
    std::optional<Error> error;
    const Fields fields(tile, "", error);
    scene::LodNode& node = tileset.nodes[i];
    std::string refine = i == 0 || !tileset.is_additive ? "REPLACE" : "ADD", uri;
    std::uint64_t bytes = 0;
    std::uint32_t scene_node = no_scene_node;
    std::optional<std::uint64_t> id;
    fields.require("geometricError", node.error);
    fields.read("refine", refine);
    if (const auto content = fields.object("content")) content->read("uri", uri);
    if (const auto extras = fields.object("extras")) {
        extras->read("triangles", node.triangles);
        extras->read("bytes", bytes);
        extras->read("node", scene_node);
        extras->read("id", id);
    }
    if (error) return *error;
    if (refine != "REPLACE" && refine != "ADD") return invalid_input("its refinement is neither REPLACE nor ADD");
    if (i == 0) tileset.is_additive = refine == "ADD";
    if (tileset.is_additive != (refine == "ADD"))
        return fail(ErrorCode::unsupported, "its refinement is another than the root's");
    if (uri.empty()) return fail(ErrorCode::unsupported, "it has no content");
    const auto volume = tile.find("boundingVolume");
    if (volume == tile.end()) return invalid_input("it has no bounding volume");
    const Result<Mat4d> transform = read_transform(tile);
    if (!transform) return transform.error();
    const Mat4d matrix = i == 0 ? *transform : tileset.matrices[node.parent] * *transform;
    if (const Status valid = scene::validate({matrix, true}); !valid)
        return invalid_input("its transform " + valid.error().message);
    const Result<Box> box = read_box(*volume, matrix);
    if (!box) return box.error();
    node.box = *box;
    node.error *= error_scale(matrix);
    tileset.matrices.push_back(matrix);
    tileset.scene_nodes.push_back(scene_node);
    if (id) tileset.ids.push_back(*id);
    tileset.uris.push_back(std::move(uri));
    tileset.bytes.push_back(bytes);
    return Nothing{};
}

// Whether every tile tells another one.
bool are_ids(std::vector<std::uint64_t> ids, std::size_t tiles) {
    std::sort(ids.begin(), ids.end());
    return ids.size() == tiles && std::adjacent_find(ids.begin(), ids.end()) == ids.end();
}

// 0 where it tells none of ours.
std::uint64_t read_revision(const Json& tileset) {
    const auto asset = tileset.find("asset");
    if (asset == tileset.end() || !asset->is_object() || !asset->contains("tilesetVersion")) return 0;
    const Json& version = (*asset)["tilesetVersion"];
    std::uint64_t revision = 0;
    if (version.is_string()) {
        const auto& text = version.get_ref<const std::string&>();
        const auto read = std::from_chars(text.data(), text.data() + text.size(), revision);
        if (read.ec != std::errc() || read.ptr != text.data() + text.size()) return 0;
    }
    return revision;
}

}  // namespace

std::string to_json(const Tileset& tileset) {
    const scene::LodTree& tree = tileset.nodes;
    const std::string version =
        tileset.revision == 0 ? "" : ",\"tilesetVersion\":\"" + std::to_string(tileset.revision) + '"';
    std::string json =
        "{\"asset\":{\"version\":\"1.1\"" + version + "},\"geometricError\":" + number(root_error(tree.front())) +
        ",\"root\":" + opened_tile(tileset, 0) + ",\"refine\":\"" + (tileset.is_additive ? "ADD" : "REPLACE") + '"';
    struct Open {
        std::uint32_t tile, next_child;
    };
    std::vector<Open> open{{0, 0}};
    while (!open.empty()) {
        const scene::LodNode& tile = tree[open.back().tile];
        const std::uint32_t child = open.back().next_child++;
        if (child < tile.child_count) {
            json += child == 0 ? ",\"children\":[" : ",";
            json += opened_tile(tileset, tile.first_child + child);
            open.push_back({tile.first_child + child, 0});
            continue;
        }
        json += tile.child_count > 0 ? "]}" : "}";
        open.pop_back();
    }
    return json + "}";
}

Result<Tileset> parse_tileset(std::string_view text) {
    const Result<Json> json = parse_json(text, max_tileset_depth);
    if (!json) return json.error();
    if (!json->is_object() || !json->contains("root")) return invalid_input("a tileset has no root");
    Tileset tileset;
    std::vector<const Json*> tiles{&(*json)["root"]};
    tileset.nodes.emplace_back();
    for (std::size_t i = 0; i < tiles.size(); ++i) {
        if (Status read = read_tile(*tiles[i], tileset, i); !read)
            return fail(read.error().code, "tile " + std::to_string(i) + ": " + read.error().message);
        const auto children = tiles[i]->find("children");
        if (children == tiles[i]->end()) continue;
        if (!children->is_array() || children->size() > max_tiles - tiles.size())
            return fail(ErrorCode::limit_exceeded, "a tileset of more than " + std::to_string(max_tiles) + " tiles");
        tileset.nodes[i].first_child = children->empty() ? 0 : static_cast<std::uint32_t>(tiles.size());
        tileset.nodes[i].child_count = static_cast<std::uint32_t>(children->size());
        for (const Json& child : *children) {
            tiles.push_back(&child);
            tileset.nodes.emplace_back().parent = static_cast<std::uint32_t>(i);
        }
    }
    const auto stays = [](const Mat4d& matrix) { return matrix == Mat4d(1.0); };
    if (std::all_of(tileset.matrices.begin(), tileset.matrices.end(), stays)) tileset.matrices.clear();
    if (!are_ids(tileset.ids, tileset.nodes.size())) tileset.ids.clear();
    tileset.revision = read_revision(*json);
    scene::keep_the_laws(tileset.nodes);
    if (Status valid = scene::validate(tileset.nodes); !valid) return valid.error();
    return tileset;
}

}  // namespace lodestream::proto
