#include "server/http/tileset.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace lodestream::http {

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
std::string opened_tile(const scene::LodNode& tile, const std::string& uri) {
    return "{\"boundingVolume\":" + box_json(tile.box) + ",\"geometricError\":" + number(tile.error) +
           ",\"content\":{\"uri\":" + quoted(uri) + "}";
}

double root_error(const scene::LodNode& root) {
    const Vec3d half = root.box.max / 2.0 - root.box.min / 2.0;
    return std::max(2.0 * std::hypot(half.x, half.y, half.z), root_error_factor * root.error);
}

}  // namespace

std::string tileset_json(std::span<const scene::LodNode> tree, const std::function<std::string(std::size_t)>& uri) {
    std::string json = "{\"asset\":{\"version\":\"1.1\"},\"geometricError\":" + number(root_error(tree.front())) +
                       ",\"root\":" + opened_tile(tree.front(), uri(0)) + ",\"refine\":\"REPLACE\"";
    struct Open {
        std::uint32_t tile, next_child;
    };
    std::vector<Open> open{{0, 0}};
    while (!open.empty()) {
        const scene::LodNode& tile = tree[open.back().tile];
        const std::uint32_t child = open.back().next_child++;
        if (child < tile.child_count) {
            json += child == 0 ? ",\"children\":[" : ",";
            json += opened_tile(tree[tile.first_child + child], uri(tile.first_child + child));
            open.push_back({tile.first_child + child, 0});
            continue;
        }
        json += tile.child_count > 0 ? "]}" : "}";
        open.pop_back();
    }
    return json + "}";
}

}  // namespace lodestream::http
