#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "common/base/transform.h"
#include "common/scene/placement.h"
#include "server/importer/formats.h"
#include "server/importer/gltf_accessor.h"
#include "server/importer/gltf_document.h"
#include "server/importer/gltf_material.h"
#include "server/importer/gltf_nodes.h"
#include "server/importer/gltf_primitive.h"

namespace lodestream::importer {
namespace {

constexpr std::uint32_t glb_header_bytes = 12, chunk_header_bytes = 8;
constexpr std::uint32_t json_chunk = 0x4E4F534A, binary_chunk = 0x004E4942;

std::uint32_t u32_at(std::span<const std::byte> bytes, std::uint64_t offset) {
    std::uint32_t value = 0;
    for (std::uint64_t i = 4; i-- > 0;) value = value << 8 | std::to_integer<std::uint32_t>(bytes[offset + i]);
    return value;
}

// Positions go through `position`, normals through `direction` (the inverse transpose up to a factor), and triangles
// turn round where the transform mirrors.
struct Transform {
    Mat4d position{1.0};
    Mat3d direction{1.0};
    bool mirrors = false;
};

Transform transform_of(const Mat4d& matrix) {
    Transform t;
    t.position = matrix;
    Mat3d m(matrix);
    double size = 0;
    for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) size = std::max(size, std::abs(m[c][r]));
    if (size > 0 && std::isfinite(size)) m /= size;
    // The cofactors are the inverse transpose times the determinant, and exist where a scale is zero.
    const Mat3d cofactors(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1]));
    t.mirrors = glm::dot(m[0], cofactors[0]) < 0;
    t.direction = t.mirrors ? -1.0 * cofactors : cofactors;
    return t;
}

// Whether a shape's tiles can be put there by the matrix alone. Twice as far: places are told from the model's origin,
// which is somewhere between.
bool can_place_a_shape(Mat4d matrix) {
    matrix[3] = Vec4d(2.0 * Vec3d(matrix[3]), matrix[3].w);
    return scene::validate({matrix, true}).ok();
}

// A primitive that is shown, with its material's place.
struct Part {
    GltfPrimitive primitive;
    std::uint32_t material = 0;
};

std::uint64_t triangles_of(const std::vector<Part>& parts) {
    std::uint64_t triangles = 0;
    for (const Part& part : parts) triangles += part.primitive.triangles.size();
    return triangles;
}

bool is_within_reach(const std::vector<Part>& parts) {
    const auto is_near = [](const Vec3f& p) {
        return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) <= scene::max_coordinate;
    };
    return std::ranges::all_of(parts,
                               [&](const Part& p) { return std::ranges::all_of(p.primitive.positions, is_near); });
}

// How the nodes that show a mesh have it: most as triangles of their own, those of one shape as its instances.
struct Uses {
    std::vector<std::size_t> own;
    std::array<std::vector<std::size_t>, 2> shared;  // as it is, mirrored

    std::uint64_t copies() const { return own.size() + (shared[0].empty() ? 0 : 1) + (shared[1].empty() ? 0 : 1); }
};

Uses uses_of(const std::vector<Part>& parts, std::span<const GltfInstance> instances) {
    Uses uses;
    const std::uint64_t triangles = triangles_of(parts);
    const bool can_share = triangles >= least_shared_triangles && is_within_reach(parts);
    for (std::size_t i = 0; i < instances.size(); ++i) {
        const bool fits = can_share && instances[i].skin < 0 && can_place_a_shape(instances[i].to_world);
        (fits ? uses.shared[transform_of(instances[i].to_world).mirrors ? 1 : 0] : uses.own).push_back(i);
    }
    for (std::vector<std::size_t>& alike : uses.shared) {
        if (alike.empty() || (alike.size() - 1) * triangles >= least_saved_triangles) continue;
        uses.own.insert(uses.own.end(), alike.begin(), alike.end());
        alike.clear();
    }
    return uses;
}

class Reader {
  public:
    Reader(const GltfDocument& document, const Source& source, Soup& soup)
        : document_(document),
          source_(source),
          soup_(soup),
          accessors_(document, source.limits),
          materials_(document, accessors_, source, soup) {}

    Status read() {
        warn_of_what_is_left_out();
        Result<GltfScene> scene = walk_nodes(document_, accessors_, source_.limits);
        if (!scene) return scene.error();
        scene_ = std::move(*scene);
        if (scene_.instances.empty() && !document_.json.meshes.empty())
            return invalid_input("has meshes but no node that shows one");
        const auto& all = scene_.instances;
        soup_.may_be_cloud = std::ranges::none_of(all, [&](const GltfInstance& i) { return has_triangles(i.mesh); });
        for (std::size_t begin = 0, end = 0; begin < all.size(); begin = end) {
            while (end < all.size() && all[end].mesh == all[begin].mesh) ++end;
            if (const Status read = read_mesh(begin, std::span(all).subspan(begin, end - begin)); !read) return read;
        }
        soup_.graph.parents = scene_.parents;
        for (const GltfInstance& instance : all) soup_.graph.object_nodes.push_back(instance.node);
        soup_.objects = objects_;
        if (objects_ > 1) soup_.kind = mesh::Kind::scene;
        return Nothing{};
    }

  private:
    void warn_of_what_is_left_out() {
        for (const std::string& extension : document_.json.extensionsUsed)
            if (!is_handled_gltf_extension(extension)) soup_.warn("extension " + extension.substr(0, 64) + " ignored");
        if (document_.has_animations) soup_.warn("animations left out: taken in the rest pose");
        if (!document_.json.skins.empty()) soup_.warn("skins taken in the rest pose");
    }

    bool has_triangles(int mesh) const {
        return std::ranges::any_of(document_.json.meshes[static_cast<std::size_t>(mesh)].primitives,
                                   [](const tinygltf::Primitive& p) { return p.mode >= TINYGLTF_MODE_TRIANGLES; });
    }

    // `first`: which object the first instance is.
    Status read_mesh(std::size_t first, std::span<const GltfInstance> instances) {
        const int index = instances.front().mesh;
        const tinygltf::Mesh& mesh = document_.json.meshes[static_cast<std::size_t>(index)];
        std::vector<Part> parts;
        for (std::size_t i = 0; i < mesh.primitives.size(); ++i) {
            Result<std::optional<Part>> part = read_part(mesh.primitives[i], mesh.weights);
            if (!part)
                return fail(part.error().code, "mesh " + std::to_string(index) + " primitive " + std::to_string(i) +
                                                   ": " + part.error().message);
            if (*part) parts.push_back(**std::move(part));
        }
        if (const Status placed = place_mesh(parts, first, instances); !placed)
            return fail(placed.error().code, "mesh " + std::to_string(index) + ": " + placed.error().message);
        if (triangles_of(parts) > 0) objects_ += instances.size();
        return Nothing{};
    }

    // None where it is not shown.
    Result<std::optional<Part>> read_part(const tinygltf::Primitive& from, const std::vector<double>& weights) {
        if (from.mode < TINYGLTF_MODE_POINTS || from.mode > TINYGLTF_MODE_TRIANGLE_FAN)
            return invalid_input("states the unknown mode " + std::to_string(from.mode));
        if (from.mode < TINYGLTF_MODE_TRIANGLES && !(soup_.may_be_cloud && from.mode == TINYGLTF_MODE_POINTS)) {
            if (from.attributes.count("POSITION") > 0) ++soup_.other_primitives;
            return std::optional<Part>();
        }
        const Result<GltfMaterialUse> use = materials_.use(from.material);
        if (!use) return use.error();
        Result<GltfPrimitive> primitive = read_primitive(from, weights, use->coordinates, accessors_, source_.limits);
        if (!primitive) return primitive.error();
        if (!from.targets.empty()) soup_.warn("morph targets taken in the rest pose: at their default weights");
        return std::optional(Part{*std::move(primitive), use->material});
    }

    Status place_mesh(const std::vector<Part>& parts, std::size_t first, std::span<const GltfInstance> instances) {
        const Uses uses = uses_of(parts, instances);
        if (const Status fits = admit_copies(parts, uses.copies(), instances.size()); !fits) return fits;
        const auto object_of = [&](std::size_t i) { return static_cast<std::uint32_t>(first + i); };
        for (const Part& part : parts)
            for (const std::size_t i : uses.own) {
                soup_.object = object_of(i);
                if (const Status placed = place(part, instances[i]); !placed) return placed;
            }
        for (const bool mirrored : {false, true}) {
            const std::vector<std::size_t>& alike = uses.shared[mirrored ? 1 : 0];
            if (alike.empty()) continue;
            // So no viewer has to turn a placed tile's triangles round.
            const Mat4d own = matrix_of(Vec3d{0}, {0, 0, 0, 1}, {mirrored ? -1.0 : 1.0, 1.0, 1.0});
            const std::uint32_t shape = soup_.begin_shape();
            for (const Part& part : parts)
                if (const Status placed = place(part, {0, -1, own, 0}); !placed) return placed;
            for (const std::size_t i : alike)
                soup_.instances.push_back({object_of(i), shape, instances[i].to_world * own});
        }
        return Nothing{};
    }

    // `copies`: of the parts' triangles in memory; `shown`: how often they are seen.
    Status admit_copies(const std::vector<Part>& parts, std::uint64_t copies, std::uint64_t shown) {
        std::uint64_t vertices = 0;
        for (const Part& part : parts) vertices += part.primitive.positions.size();
        shown_triangles_ += shown * triangles_of(parts);
        if (shown_triangles_ > source_.limits.shown_triangles)
            return fail(ErrorCode::limit_exceeded, "shows " + std::to_string(shown_triangles_) +
                                                       " triangles with those before, more than the limit of " +
                                                       std::to_string(source_.limits.shown_triangles));
        return admit(soup_.positions.size() + copies * vertices, soup_.triangles.size() + copies * triangles_of(parts),
                     source_.limits);
    }

    Status place(const Part& part, const GltfInstance& instance) {
        const auto& [primitive, material] = part;
        const auto first = static_cast<std::uint32_t>(soup_.positions.size());
        Transform transform = transform_of(instance.to_world);
        const bool skinned = instance.skin >= 0 && !primitive.joints.empty();
        const std::vector<Mat4d>* joints = nullptr;
        if (skinned) {
            const Result<const std::vector<Mat4d>*> found = joints_of(instance.skin);
            if (!found) return found.error();
            joints = *found;
            transform = Transform{};  // a skin replaces the node's own transform
        }
        for (std::uint32_t i = 0; i < primitive.positions.size(); ++i) {
            if (skinned) transform = transform_of(skinned_matrix(*joints, primitive.joints[i], primitive.weights[i]));
            const Vec3d p(primitive.positions[i]);
            const std::uint32_t v = soup_.add_vertex(Vec3d(transform.position * Vec4d(p, 1.0)));
            if (!primitive.normals.empty())
                soup_.set_normal(v, Vec3f(transform.direction * Vec3d(primitive.normals[i])));
            if (!primitive.texture_coordinates.empty())
                soup_.set_texture_coordinate(v, primitive.texture_coordinates[i]);
            if (!primitive.colors.empty()) soup_.set_color(v, primitive.colors[i]);
            if (primitive.triangles.empty()) tint(v, soup_.materials[material].base_color);
        }
        for (const auto& [a, b, c] : primitive.triangles) {
            if (transform.mirrors)
                soup_.add_triangle({first + a, first + c, first + b}, material);
            else
                soup_.add_triangle({first + a, first + b, first + c}, material);
        }
        return Nothing{};
    }

    // A cloud has one material, so a point's colour has its own in it.
    void tint(std::uint32_t vertex, const Vec4f& base_color) {
        if (base_color == Vec4f(1.0f)) return;
        const Rgba8 own = vertex < soup_.colors.size() ? soup_.colors[vertex] : Rgba8(255);
        soup_.set_color(vertex, quantized(Vec4f(own) / 255.0f * base_color));
    }

    // The weighted mean of the joints' matrices; of the unit matrix where no weight is left.
    static Mat4d skinned_matrix(const std::vector<Mat4d>& joints, const Vec4f& which, const Vec4f& weights) {
        Mat4d sum(0.0);
        double total = 0;
        for (int k = 0; k < 4; ++k) {
            const double weight = weights[k];
            if (!(weight > 0) || !(which[k] >= 0) || which[k] >= static_cast<float>(joints.size())) continue;
            sum += weight * joints[static_cast<std::size_t>(which[k])];
            total += weight;
        }
        return total > 0 && std::isfinite(total) ? sum / total : Mat4d(1.0);
    }

    // From the mesh's own space into the world, by joint.
    Result<const std::vector<Mat4d>*> joints_of(int skin) {
        const std::string name = "skin " + std::to_string(skin);
        if (static_cast<std::size_t>(skin) >= document_.json.skins.size())
            return invalid_input(name + " does not exist");
        const auto known = skins_.find(skin);
        if (known != skins_.end()) return &known->second;
        const tinygltf::Skin& from = document_.json.skins[static_cast<std::size_t>(skin)];
        std::vector<Mat4d> joints;
        for (const int joint : from.joints) {
            if (joint < 0 || static_cast<std::size_t>(joint) >= scene_.node_to_world.size())
                return invalid_input(name + " has a joint that does not exist");
            joints.push_back(scene_.node_to_world[static_cast<std::size_t>(joint)]);
        }
        if (from.inverseBindMatrices >= 0) {
            const Result<GltfAccessors::Floats> inverse =
                accessors_.floats(from.inverseBindMatrices, 16, 16, joints.size(), name);
            if (!inverse) return inverse.error();
            for (std::size_t j = 0; j < joints.size(); ++j) {
                Mat4d bind;
                for (int k = 0; k < 16; ++k) bind[k / 4][k % 4] = inverse->values[16 * j + static_cast<std::size_t>(k)];
                joints[j] *= bind;
            }
        }
        return &skins_.emplace(skin, std::move(joints)).first->second;
    }

    const GltfDocument& document_;
    const Source& source_;
    Soup& soup_;
    GltfAccessors accessors_;
    GltfMaterials materials_;
    GltfScene scene_;
    std::map<int, std::vector<Mat4d>> skins_;
    std::uint64_t objects_ = 0;
    std::uint64_t shown_triangles_ = 0;  // those of instances counted as often as they are seen
};

Status read_document(std::span<const std::byte> json, std::span<const std::byte> chunk, const Source& source,
                     Soup& soup) {
    const Result<GltfDocument> document = open_gltf(json, chunk, source);
    if (!document) return document.error();
    return Reader(*document, source, soup).read();
}

}  // namespace

Status read_gltf(const Source& source, Soup& soup) {
    if (source.bytes.size() >= 4 && u32_at(source.bytes, 0) == 0x46546C67) return read_glb(source, soup);
    return read_document(source.bytes, {}, source, soup);
}

Status read_glb(const Source& source, Soup& soup) {
    const std::span<const std::byte> bytes = source.bytes;
    if (bytes.size() < glb_header_bytes + chunk_header_bytes) return invalid_input("is too short for a GLB file");
    if (u32_at(bytes, 0) != 0x46546C67) return invalid_input("does not begin with \"glTF\"");
    const std::uint32_t version = u32_at(bytes, 4), length = u32_at(bytes, 8);
    if (version != 2)
        return fail(ErrorCode::unsupported, "is GLB version " + std::to_string(version) + "; only 2 is supported");
    if (length > bytes.size())
        return invalid_input("states " + std::to_string(length) + " bytes but holds " + std::to_string(bytes.size()));
    std::span<const std::byte> json, binary;
    std::uint64_t at = glb_header_bytes;
    for (int chunk = 0; at + chunk_header_bytes <= length; ++chunk) {
        const std::uint64_t size = u32_at(bytes, at);
        const std::uint32_t type = u32_at(bytes, at + 4);
        at += chunk_header_bytes;
        if (size > length - at) return invalid_input("has a chunk longer than the file");
        if (chunk == 0 && type != json_chunk) return invalid_input("does not begin with a JSON chunk");
        if (chunk == 0) json = bytes.subspan(at, size);
        if (chunk == 1 && type == binary_chunk) binary = bytes.subspan(at, size);
        at += size;
    }
    if (json.empty()) return invalid_input("has no JSON chunk");
    return read_document(json, binary, source, soup);
}

}  // namespace lodestream::importer
