#include "proto/tileset.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>
#include <numeric>
#include <optional>
#include <string>
#include <utility>
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

// Of what is told of some tiles, in order.
std::uint64_t joined(std::uint64_t told, std::string_view more) {
    constexpr std::uint64_t prime = 0x100000001b3;  // FNV-1a
    for (const char c : more) told = (told ^ static_cast<unsigned char>(c)) * prime;
    return told;
}

std::uint64_t joined(std::uint64_t told, std::uint64_t more) {
    std::array<char, sizeof more> bytes{};
    std::memcpy(bytes.data(), &more, sizeof more);
    return joined(told, std::string_view(bytes.data(), bytes.size()));
}

// Another one where anything of the tile itself is.
std::uint64_t told_of(const Tileset& tileset, std::size_t i) {
    const scene::LodNode& tile = tileset.nodes[i];
    std::uint64_t told = joined(tile.triangles, tileset.uris[i]);
    const auto add = [&](double value) { told = joined(told, std::bit_cast<std::uint64_t>(value)); };
    add(tile.error);
    for (int axis = 0; axis < 3; ++axis) {
        add(tile.box.min[axis]);
        add(tile.box.max[axis]);
    }
    for (const double value : numbers_of(tileset.matrix(i))) add(value);
    return joined(told, tileset.ids[i]);
}

// All of a tile of `document` but its children and what closes it.
std::string opened_tile(const Tileset& tileset, std::size_t i, std::size_t document) {
    const scene::LodNode& tile = tileset.nodes[i];
    const Mat4d matrix = tileset.matrix(i);
    const std::uint32_t node = tileset.scene_nodes.empty() ? no_scene_node : tileset.scene_nodes[i];
    const bool begins_another = i != document && begins_document(tileset, i);
    const bool is_placed_above = i == document && i != 0;  // by the tile that names this document
    return "{" + (is_placed_above ? "" : transform_json(tileset, i)) +
           "\"boundingVolume\":" + box_json(tile.box, matrix) +
           ",\"geometricError\":" + number(tile.error / error_scale(matrix)) +
           ",\"content\":{\"uri\":" + quoted(begins_another ? tileset.documents[i] : tileset.uris[i]) +
           "},\"extras\":{\"triangles\":" + std::to_string(tile.triangles) +
           ",\"bytes\":" + std::to_string(tileset.bytes[i]) +
           (node == no_scene_node ? "" : ",\"node\":" + std::to_string(node)) +
           (tileset.ids.empty() ? "" : ",\"id\":" + std::to_string(tileset.ids[i])) +
           (begins_another ? ",\"content\":" + quoted(tileset.uris[i]) : "") + "}";
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

// Whether content at this address is another document, as far as its name tells.
bool is_document(std::string_view uri) {
    return uri.substr(0, uri.find_first_of("?#")).ends_with(".json");
}

// Into the node at `i`, which is there, and its content behind those before. `place`: of the root.
Status read_tile(const Json& tile, Tileset& tileset, std::size_t i, const Mat4d& place) {
    if (!tile.is_object()) return invalid_input("is no object");
    std::optional<Error> error;
    const Fields fields(tile, "", error);
    scene::LodNode& node = tileset.nodes[i];
    std::string refine = i == 0 || !tileset.is_additive ? "REPLACE" : "ADD", uri, content_of_document;
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
        extras->read("content", content_of_document);
    }
    if (error) return *error;
    if (refine != "REPLACE" && refine != "ADD") return invalid_input("its refinement is neither REPLACE nor ADD");
    if (i == 0) tileset.is_additive = refine == "ADD";
    if (tileset.is_additive != (refine == "ADD"))
        return fail(ErrorCode::unsupported, "its refinement is another than the root's");
    std::string document;
    if (is_document(uri)) document = std::exchange(uri, std::move(content_of_document));
    if (uri.empty()) return fail(ErrorCode::unsupported, "it has no content");
    const auto volume = tile.find("boundingVolume");
    if (volume == tile.end()) return invalid_input("it has no bounding volume");
    const Result<Mat4d> transform = read_transform(tile);
    if (!transform) return transform.error();
    const Mat4d matrix = i == 0 ? place * *transform : tileset.matrices[node.parent] * *transform;
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
    tileset.documents.push_back(std::move(document));
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

std::string to_json(const Tileset& tileset, std::uint32_t document) {
    const scene::LodTree& tree = tileset.nodes;
    const std::string version =
        tileset.revision == 0 ? "" : ",\"tilesetVersion\":\"" + std::to_string(tileset.revision) + '"';
    std::string json = "{\"asset\":{\"version\":\"1.1\"" + version +
                       "},\"geometricError\":" + number(root_error(tree[document])) +
                       ",\"root\":" + opened_tile(tileset, document, document) + ",\"refine\":\"" +
                       (tileset.is_additive ? "ADD" : "REPLACE") + '"';
    struct Open {
        std::uint32_t tile, next_child;
    };
    const auto children = [&](std::uint32_t tile) {
        return tile != document && begins_document(tileset, tile) ? 0 : tree[tile].child_count;
    };
    std::vector<Open> open{{document, 0}};
    while (!open.empty()) {
        const std::uint32_t tile = open.back().tile, child = open.back().next_child++;
        if (child < children(tile)) {
            json += child == 0 ? ",\"children\":[" : ",";
            json += opened_tile(tileset, tree[tile].first_child + child, document);
            open.push_back({tree[tile].first_child + child, 0});
            continue;
        }
        json += children(tile) > 0 ? "]}" : "}";
        open.pop_back();
    }
    return json + "}";
}

void split_into_documents(Tileset& tileset,
                          const std::function<std::string(std::uint64_t id, std::uint64_t version)>& address) {
    const scene::LodTree& tree = tileset.nodes;
    if (tree.size() <= max_document_tiles) return;
    if (tileset.ids.empty()) {
        tileset.ids.resize(tree.size());
        std::iota(tileset.ids.begin(), tileset.ids.end(), 0);
    }
    std::vector<std::size_t> sizes(tree.size(), 1);  // of a tile and all below it
    std::vector<std::uint64_t> versions(tree.size());
    for (std::size_t i = tree.size(); i-- > 0;) {
        versions[i] = joined(versions[i], told_of(tileset, i));
        if (i == 0) break;
        sizes[tree[i].parent] += sizes[i];
        versions[tree[i].parent] = joined(versions[tree[i].parent], versions[i]);
    }
    tileset.documents.assign(tree.size(), "");
    for (std::size_t i = 1; i < tree.size(); ++i)
        if (tree[i].child_count > 0 && sizes[i] <= max_document_tiles && sizes[tree[i].parent] > max_document_tiles)
            tileset.documents[i] = address(tileset.ids[i], versions[i]);
}

Result<Tileset> parse_tileset(std::string_view text) {
    return parse_document(text, Mat4d(1.0));
}

Result<Tileset> parse_document(std::string_view text, const Mat4d& place) {
    const Result<Json> json = parse_json(text, max_tileset_depth);
    if (!json) return json.error();
    if (!json->is_object() || !json->contains("root")) return invalid_input("a tileset has no root");
    Tileset tileset;
    std::vector<const Json*> tiles{&(*json)["root"]};
    tileset.nodes.emplace_back();
    for (std::size_t i = 0; i < tiles.size(); ++i) {
        if (Status read = read_tile(*tiles[i], tileset, i, place); !read)
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
    const auto is_empty = [](const std::string& document) { return document.empty(); };
    if (std::all_of(tileset.documents.begin(), tileset.documents.end(), is_empty)) tileset.documents.clear();
    if (!are_ids(tileset.ids, tileset.nodes.size())) tileset.ids.clear();
    tileset.revision = read_revision(*json);
    scene::keep_the_laws(tileset.nodes);
    if (Status valid = scene::validate(tileset.nodes); !valid) return valid.error();
    return tileset;
}

Status add_document(Tileset& tileset, std::uint32_t node, const Tileset& document) {
    const std::size_t first = tileset.nodes.size(), more = document.nodes.size() - 1;
    if (more > max_tiles - first)
        return fail(ErrorCode::limit_exceeded, "a tileset of more than " + std::to_string(max_tiles) + " tiles");
    // Where a tile of the document is, below `node`.
    const auto place = [&](std::uint32_t tile) {
        return tile == 0 ? node : static_cast<std::uint32_t>(first + tile - 1);
    };
    for (std::uint32_t tile = 0; tile <= more; ++tile) {
        scene::LodNode told = document.nodes[tile];
        told.parent = tile == 0 ? tileset.nodes[node].parent : place(told.parent);
        if (told.child_count > 0) told.first_child = place(told.first_child);
        if (tile == 0)
            tileset.nodes[node] = told;
        else
            tileset.nodes.push_back(told);
    }
    const auto add = [&](auto& to, const auto& from, const auto& usual) {
        if (to.empty() && from.empty()) return;
        if (to.empty()) to.assign(first, usual);
        to.resize(first + more, usual);
        if (from.empty()) return;
        to[node] = from[0];
        std::copy(from.begin() + 1, from.end(), to.begin() + static_cast<std::ptrdiff_t>(first));
    };
    add(tileset.uris, document.uris, std::string());
    add(tileset.bytes, document.bytes, std::uint64_t{0});
    add(tileset.matrices, document.matrices, Mat4d(1.0));
    add(tileset.scene_nodes, document.scene_nodes, no_scene_node);
    add(tileset.documents, document.documents, std::string());
    if (document.documents.empty() && !tileset.documents.empty()) tileset.documents[node].clear();
    add(tileset.ids, document.ids, std::uint64_t{0});
    if (!are_ids(tileset.ids, tileset.nodes.size())) tileset.ids.clear();
    scene::keep_the_laws(tileset.nodes);
    return Nothing{};
}

}  // namespace lodestream::proto
