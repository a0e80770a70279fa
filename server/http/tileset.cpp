#include "server/http/tileset.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <charconv>
#include <cmath>
#include <limits>

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

struct Extent {
    std::array<double, 3> center{};
    std::array<double, 3> half{};
    double diagonal = 0.0;
};

Extent extent_of(const proto::Asset& asset) {
    Extent extent;
    const auto& low = *asset.bounds_min;
    const auto& high = *asset.bounds_max;
    for (std::size_t i = 0; i < 3; ++i) {
        extent.half[i] = high[i] / 2.0 - low[i] / 2.0;
        extent.center[i] = low[i] + extent.half[i];
    }
    extent.diagonal = 2.0 * std::hypot(extent.half[0], extent.half[1], extent.half[2]);
    return extent;
}

// Centre and half axes, turned from y up to z up.
std::string box_json(const Extent& extent) {
    const auto& [x, y, z] = extent.center;
    const auto& [hx, hy, hz] = extent.half;
    const std::array<double, 12> box{x, -z, y, hx, 0.0, 0.0, 0.0, hz, 0.0, 0.0, 0.0, hy};
    std::string text = "{\"box\":[";
    for (std::size_t i = 0; i < box.size(); ++i) text += (i ? "," : "") + number(box[i] + 0.0);
    return text + "]}";
}

}  // namespace

bool has_tileset(const proto::Asset& asset) {
    return asset.status == proto::AssetStatus::ready && !asset.levels.empty() && asset.bounds_min && asset.bounds_max;
}

std::string tileset_json(const proto::Asset& asset) {
    assert(has_tileset(asset));
    const Extent extent = extent_of(asset);
    const std::string volume = box_json(extent);
    std::string tile;
    double error = 0.0;  // never falls on the way up, as the standard wants it
    for (const proto::Level& level : asset.levels) {
        error = std::max(error, level.max_error);
        tile = "{\"boundingVolume\":" + volume + ",\"geometricError\":" + number(error) + ",\"refine\":\"REPLACE\"" +
               ",\"content\":{\"uri\":" + quoted(level.url) + "}" +
               (tile.empty() ? "" : ",\"children\":[" + tile + "]") + "}";
    }
    return "{\"asset\":{\"version\":\"1.1\"},\"geometricError\":" +
           number(std::max(extent.diagonal, root_error_factor * error)) + ",\"root\":" + tile + "}";
}

}  // namespace lodestream::http
