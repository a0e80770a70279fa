#include "proto/tileset.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "proto/json_reader.h"

namespace lodestream::proto {

namespace {

constexpr double root_error_factor =
    2.0;  // of not drawing the model at all, over its coarsest level's; at least the diagonal

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

// Centre and half axes, turned from y up to z up.
std::string box_json(const Box& box) {
    const Vec3d half = box.max / 2.0 - box.min / 2.0, center = box.min + half;
    const std::array<double, 12> numbers{center.x, -center.z, center.y, half.x, 0.0, 0.0,
                                         0.0,      half.z,    0.0,      0.0,    0.0, half.y};
    std::string text = "{\"box\":[";
    for (std::size_t i = 0; i < numbers.size(); ++i) text += (i > 0 ? "," : "") + number(numbers[i] + 0.0);
    return text + "]}";
}

// All of a tile but its children and what closes it.
std::string opened_tile(const Tileset& tileset, std::size_t i) {
    const scene::LodNode& tile = tileset.nodes[i];
    return "{\"boundingVolume\":" + box_json(tile.box) + ",\"geometricError\":" + number(tile.error) +
           ",\"content\":{\"uri\":" + quoted(tileset.uris[i]) +
           "},\"extras\":{\"triangles\":" + std::to_string(tile.triangles) +
           ",\"bytes\":" + std::to_string(tileset.bytes[i]) + "}";
}

double root_error(const scene::LodNode& root) {
    const Vec3d half = root.box.max / 2.0 - root.box.min / 2.0;
    return std::max(2.0 * std::hypot(half.x, half.y, half.z), root_error_factor * root.error);
}

// A box's centre and three half axes, turned from z up to y up; oriented ones as the box around them.
Result<Box> read_box(const Json& volume) {
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
    const Vec3d half = glm::abs(v[1]) + glm::abs(v[2]) + glm::abs(v[3]);
    if (!all_finite(v[0] - half) || !all_finite(v[0] + half)) return invalid_input("its box is not finite");
    return Box{v[0] - half, v[0] + half};
}

// Into the node at `i`, which is there, and its content behind those before.
Status read_tile(const Json& tile, Tileset& tileset, std::size_t i) {
    if (!tile.is_object()) return invalid_input("is no object");
    std::optional<Error> error;
    const Fields fields(tile, "", error);
    scene::LodNode& node = tileset.nodes[i];
    std::string refine = "REPLACE", uri;
    std::uint64_t bytes = 0;
    fields.require("geometricError", node.error);
    fields.read("refine", refine);
    if (const auto content = fields.object("content")) content->read("uri", uri);
    if (const auto extras = fields.object("extras")) {
        extras->read("triangles", node.triangles);
        extras->read("bytes", bytes);
    }
    if (error) return *error;
    if (refine != "REPLACE") return fail(ErrorCode::unsupported, "its refinement is not REPLACE");
    if (uri.empty()) return fail(ErrorCode::unsupported, "it has no content");
    const auto volume = tile.find("boundingVolume");
    if (volume == tile.end()) return invalid_input("it has no bounding volume");
    const Result<Box> box = read_box(*volume);
    if (!box) return box.error();
    node.box = *box;
    tileset.uris.push_back(std::move(uri));
    tileset.bytes.push_back(bytes);
    return Nothing{};
}

void keep_the_laws(scene::LodTree& nodes) {
    for (std::size_t i = nodes.size(); i-- > 1;) {
        scene::LodNode& parent = nodes[nodes[i].parent];
        parent.box.add(nodes[i].box.min);
        parent.box.add(nodes[i].box.max);
        parent.error = std::max(parent.error, nodes[i].error);
    }
}

}  // namespace

std::string to_json(const Tileset& tileset) {
    const scene::LodTree& tree = tileset.nodes;
    std::string json = "{\"asset\":{\"version\":\"1.1\"},\"geometricError\":" + number(root_error(tree.front())) +
                       ",\"root\":" + opened_tile(tileset, 0) + ",\"refine\":\"" +
                       (tileset.is_additive ? "ADD" : "REPLACE") + '"';
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
    keep_the_laws(tileset.nodes);
    if (Status valid = scene::validate(tileset.nodes); !valid) return valid.error();
    return tileset;
}

}  // namespace lodestream::proto
