#include "server/importer/gltf_primitive.h"

#include <algorithm>
#include <optional>

#include "common/codec/draco_mesh.h"

namespace lodestream::importer {
namespace {

using Floats = GltfAccessors::Floats;

constexpr std::size_t max_applied_morphs = 64;  // of default weight other than zero
constexpr const char* draco_extension = "KHR_draco_mesh_compression";

int integer_of(const tinygltf::Value& object, const char* key) {
    return object.Has(key) && object.Get(key).IsInt() ? object.Get(key).GetNumberAsInt() : -1;
}

template <class Vector>
std::vector<Vector> vectors(const Floats& floats) {
    std::vector<Vector> out(floats.count);
    for (std::size_t i = 0; i < floats.count; ++i)
        for (int k = 0; k < Vector::length(); ++k)
            out[i][k] = floats.values[i * static_cast<std::size_t>(floats.components) + static_cast<std::size_t>(k)];
    return out;
}

// Where a primitive's attributes come from: accessors, or the Draco mesh that replaces them.
class Attributes {
  public:
    Attributes(const tinygltf::Primitive& primitive, GltfAccessors& accessors)
        : primitive_(primitive), accessors_(accessors) {}

    Status open_draco(const tinygltf::Value& extension, const Limits& limits) {
        const Result<std::span<const std::byte>> bytes = accessors_.view(integer_of(extension, "bufferView"));
        if (!bytes) return bytes.error();
        Result<codec::DracoMesh> decoded = codec::decode_draco(*bytes, limits.vertices, limits.triangles);
        if (!decoded) return decoded.error();
        draco_ = std::move(*decoded);
        if (extension.Has("attributes")) draco_ids_ = extension.Get("attributes");
        return Nothing{};
    }

    const std::optional<codec::DracoMesh>& draco() const { return draco_; }
    bool has(const std::string& name) const { return primitive_.attributes.count(name) > 0; }

    // pre: has(name). `count` as in GltfAccessors::floats().
    Result<Floats> read(const std::string& name, int least, int most, std::size_t count) {
        if (draco_ && integer_of(draco_ids_, name.c_str()) >= 0) return read_draco(name, least, most);
        return accessors_.floats(primitive_.attributes.at(name), least, most, count, name);
    }

  private:
    Result<Floats> read_draco(const std::string& name, int least, int most) {
        const auto at = draco_->attributes.find(static_cast<std::uint32_t>(integer_of(draco_ids_, name.c_str())));
        if (at == draco_->attributes.end()) return invalid_input("Draco data has no attribute for " + name);
        codec::DracoAttribute& attribute = at->second;
        const std::size_t needed = std::size_t{draco_->points} * static_cast<std::size_t>(attribute.components);
        if (attribute.components < least || attribute.components > most || attribute.values.size() < needed)
            return invalid_input("Draco attribute " + name + " is of a type that glTF does not allow there");
        return Floats{draco_->points, attribute.components, attribute.values};
    }

    const tinygltf::Primitive& primitive_;
    GltfAccessors& accessors_;
    std::optional<codec::DracoMesh> draco_;
    tinygltf::Value draco_ids_{tinygltf::Value::Object{}};
};

std::vector<mesh::Triangle> assembled(int mode, const std::vector<std::uint32_t>& i) {
    std::vector<mesh::Triangle> triangles;
    if (mode == TINYGLTF_MODE_TRIANGLES)
        for (std::size_t k = 0; k + 2 < i.size(); k += 3) triangles.push_back({i[k], i[k + 1], i[k + 2]});
    else if (mode == TINYGLTF_MODE_TRIANGLE_STRIP)
        for (std::size_t k = 0; k + 2 < i.size(); ++k) triangles.push_back({i[k], i[k + 1 + k % 2], i[k + 2 - k % 2]});
    else
        for (std::size_t k = 0; k + 2 < i.size(); ++k) triangles.push_back({i[k + 1], i[k + 2], i[0]});
    return triangles;
}

Result<std::vector<mesh::Triangle>> read_triangles(const tinygltf::Primitive& primitive, const Attributes& attributes,
                                                   std::size_t vertices, GltfAccessors& accessors) {
    if (attributes.draco()) return attributes.draco()->triangles;
    std::vector<std::uint32_t> order;
    if (primitive.indices >= 0) {
        Result<std::vector<std::uint32_t>> indices = accessors.indices(primitive.indices);
        if (!indices) return indices.error();
        order = std::move(*indices);
    } else {
        order.resize(vertices);
        for (std::size_t i = 0; i < vertices; ++i) order[i] = static_cast<std::uint32_t>(i);
    }
    return assembled(primitive.mode, order);
}

Status read_faces(const tinygltf::Primitive& primitive, const Attributes& attributes, GltfAccessors& accessors,
                  GltfPrimitive& to) {
    Result<std::vector<mesh::Triangle>> triangles =
        read_triangles(primitive, attributes, to.positions.size(), accessors);
    if (!triangles) return triangles.error();
    for (const mesh::Triangle& t : *triangles)
        for (const std::uint32_t v : t)
            if (v >= to.positions.size())
                return invalid_input("has the index " + std::to_string(v) + " but only " +
                                     std::to_string(to.positions.size()) + " vertices");
    to.triangles = std::move(*triangles);
    return Nothing{};
}

Status read_optional_attributes(Attributes& attributes, const GltfTextureCoordinates& coordinates, GltfPrimitive& to) {
    const std::size_t n = to.positions.size();
    if (attributes.has("NORMAL")) {
        const Result<Floats> normals = attributes.read("NORMAL", 3, 3, n);
        if (!normals) return normals.error();
        to.normals = vectors<Vec3f>(*normals);
    }
    const std::string set = "TEXCOORD_" + std::to_string(coordinates.set);
    if (attributes.has(set)) {
        const Result<Floats> uv = attributes.read(set, 2, 2, n);
        if (!uv) return uv.error();
        to.texture_coordinates = vectors<Vec2f>(*uv);
        if (coordinates != GltfTextureCoordinates{.set = coordinates.set})
            for (Vec2f& t : to.texture_coordinates) t = coordinates.applied(t.x, t.y);
    }
    if (attributes.has("COLOR_0")) {
        const Result<Floats> colors = attributes.read("COLOR_0", 3, 4, n);
        if (!colors) return colors.error();
        const auto c = static_cast<std::size_t>(colors->components);
        for (std::size_t i = 0; i < n; ++i) {
            const float* v = colors->values.data() + i * c;
            to.colors.push_back(quantized({v[0], v[1], v[2], c > 3 ? v[3] : 1.0f}));
        }
    }
    if (attributes.has("JOINTS_0") && attributes.has("WEIGHTS_0")) {
        const Result<Floats> joints = attributes.read("JOINTS_0", 4, 4, n);
        if (!joints) return joints.error();
        const Result<Floats> weights = attributes.read("WEIGHTS_0", 4, 4, n);
        if (!weights) return weights.error();
        to.joints = vectors<Vec4f>(*joints);
        to.weights = vectors<Vec4f>(*weights);
    }
    return Nothing{};
}

Status add_morph(const std::map<std::string, int>& target, const char* name, float weight, GltfAccessors& accessors,
                 std::vector<Vec3f>& to) {
    const auto accessor = target.find(name);
    if (accessor == target.end() || to.empty()) return Nothing{};
    const Result<Floats> deltas = accessors.floats(accessor->second, 3, 3, to.size(), std::string("morph ") + name);
    if (!deltas) return deltas.error();
    const std::vector<Vec3f> by = vectors<Vec3f>(*deltas);
    for (std::size_t i = 0; i < to.size(); ++i) to[i] += weight * by[i];
    return Nothing{};
}

Status apply_morphs(const tinygltf::Primitive& primitive, const std::vector<double>& weights, GltfAccessors& accessors,
                    GltfPrimitive& to) {
    std::size_t applied = 0;
    for (std::size_t i = 0; i < std::min(weights.size(), primitive.targets.size()); ++i) {
        if (weights[i] == 0) continue;
        if (++applied > max_applied_morphs)
            return fail(ErrorCode::limit_exceeded,
                        "applies more morph targets than the limit of " + std::to_string(max_applied_morphs));
        const auto weight = static_cast<float>(weights[i]);
        Status added = add_morph(primitive.targets[i], "POSITION", weight, accessors, to.positions);
        if (added) added = add_morph(primitive.targets[i], "NORMAL", weight, accessors, to.normals);
        if (!added) return added;
    }
    return Nothing{};
}

}  // namespace

Result<GltfPrimitive> read_primitive(const tinygltf::Primitive& primitive, const std::vector<double>& morph_weights,
                                     const GltfTextureCoordinates& coordinates, GltfAccessors& accessors,
                                     const Limits& limits) {
    GltfPrimitive out;
    Attributes attributes(primitive, accessors);
    if (!attributes.has("POSITION")) return out;
    const auto extension = primitive.extensions.find(draco_extension);
    if (extension != primitive.extensions.end())
        if (const Status opened = attributes.open_draco(extension->second, limits); !opened) return opened.error();

    const Result<Floats> positions = attributes.read("POSITION", 3, 3, GltfAccessors::any_count);
    if (!positions) return positions.error();
    out.positions = vectors<Vec3f>(*positions);
    if (const Status read = read_optional_attributes(attributes, coordinates, out); !read) return read.error();
    if (primitive.mode >= TINYGLTF_MODE_TRIANGLES)
        if (const Status read = read_faces(primitive, attributes, accessors, out); !read) return read.error();
    if (const Status morphed = apply_morphs(primitive, morph_weights, accessors, out); !morphed) return morphed.error();
    return out;
}

}  // namespace lodestream::importer
