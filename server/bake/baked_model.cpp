// The stored form of a baked model, little-endian:
//   magic "LODBAKE1", then the fields below in order. A vector is its element count (u64) and its elements; a string
//   its byte count (u64) and its bytes.
#include <bit>
#include <cstring>
#include <type_traits>

#include "server/bake/bake.h"

namespace lodestream::bake {

static_assert(std::endian::native == std::endian::little,
              "the stored form is the memory's on little-endian machines only");

namespace {

constexpr char magic[] = "LODBAKE1";
constexpr std::size_t magic_bytes = sizeof(magic) - 1;

class Writer {
  public:
    std::vector<std::byte> bytes;

    void raw(const void* data, std::size_t size) {
        const auto* begin = static_cast<const std::byte*>(data);
        bytes.insert(bytes.end(), begin, begin + size);
    }
    template <class T>
    void operator()(const T& value) {
        static_assert(std::is_trivially_copyable_v<T>);
        raw(&value, sizeof value);
    }
    template <class T>
    void operator()(const std::vector<T>& values) {
        (*this)(static_cast<std::uint64_t>(values.size()));
        if constexpr (std::is_trivially_copyable_v<T>) {
            raw(values.data(), values.size() * sizeof(T));
        } else {
            for (const T& value : values) describe(*this, value);
        }
    }
    void operator()(const std::string& text) {
        (*this)(static_cast<std::uint64_t>(text.size()));
        raw(text.data(), text.size());
    }
};

// Reads what Writer wrote; after the first shortage every read gives nothing and ok() is false.
class Reader {
  public:
    explicit Reader(std::span<const std::byte> bytes) : rest_(bytes) {}

    bool ok() const { return ok_; }
    bool at_end() const { return rest_.empty(); }

    void raw(void* data, std::size_t size) {
        if (!ok_ || size > rest_.size()) {
            ok_ = false;
            return;
        }
        if (size > 0) std::memcpy(data, rest_.data(), size);
        rest_ = rest_.subspan(size);
    }
    template <class T>
    void operator()(T& value) {
        static_assert(std::is_trivially_copyable_v<T>);
        raw(&value, sizeof value);
    }
    template <class T>
    void operator()(std::vector<T>& values) {
        const std::size_t count = read_count(std::is_trivially_copyable_v<T> ? sizeof(T) : 1);
        values.resize(count);
        if constexpr (std::is_trivially_copyable_v<T>) {
            raw(values.data(), count * sizeof(T));
        } else {
            for (T& value : values) describe(*this, value);
        }
    }
    void operator()(std::string& text) {
        text.resize(read_count(1));
        raw(text.data(), text.size());
    }

  private:
    // A count that the bytes at hand can hold, so that a damaged one cannot make an allocation of its own size.
    std::size_t read_count(std::size_t element_bytes) {
        std::uint64_t count = 0;
        (*this)(count);
        if (count > rest_.size() / element_bytes) ok_ = false;
        return ok_ ? static_cast<std::size_t>(count) : 0;
    }

    std::span<const std::byte> rest_;
    bool ok_ = true;
};

// One description of each type serves reading and writing.
template <class Stream, class Material>
requires std::is_same_v<std::remove_const_t<Material>, mesh::Material>
void describe(Stream& stream, Material& m) {
    stream(m.name);
    stream(m.base_color);
    stream(m.metallic);
    stream(m.roughness);
    stream(m.emissive);
    stream(m.base_color_texture);
    stream(m.metallic_roughness_texture);
    stream(m.occlusion_texture);
    stream(m.emissive_texture);
    stream(m.alpha_mode);
    stream(m.alpha_cutoff);
    stream(m.double_sided);
}

template <class Stream, class Image>
requires std::is_same_v<std::remove_const_t<Image>, mesh::Image>
void describe(Stream& stream, Image& image) {
    stream(image.media_type);
    stream(image.bytes);
    stream(image.width);
    stream(image.height);
}

template <class Stream, class Baked>
void describe_all(Stream& stream, Baked& baked) {
    auto& model = baked.model;
    stream(model.mesh.positions);
    stream(model.mesh.normals);
    stream(model.mesh.texture_coordinates);
    stream(model.mesh.colors);
    stream(model.mesh.triangles);
    stream(model.mesh.triangle_materials);
    stream(model.materials);
    stream(model.images);
    stream(model.origin);
    stream(model.kind);
    stream(model.objects);
    stream(baked.history.vertex_parent);
    stream(baked.history.vertex_step);
    stream(baked.history.triangle_order);
    stream(baked.history.triangle_step);
}

Error damaged(const char* what) {
    return fail(ErrorCode::invalid_input, std::string("baked model is damaged: ") + what);
}

bool fits(std::size_t attribute, std::size_t elements) {
    return attribute == 0 || attribute == elements;
}

bool finite(const std::vector<Vec3f>& vectors) {
    for (const Vec3f& v : vectors)
        if (!all_finite(v)) return false;
    return true;
}

Status validate(const mesh::Model& model) {
    const mesh::Mesh& m = model.mesh;
    const std::size_t vertices = m.positions.size();
    if (!fits(m.normals.size(), vertices) || !fits(m.texture_coordinates.size(), vertices) ||
        !fits(m.colors.size(), vertices))
        return damaged("attribute counts differ");
    if (!fits(m.triangle_materials.size(), m.triangles.size())) return damaged("material count differs");
    if (!finite(m.positions) || !finite(m.normals) || !all_finite(model.origin))
        return damaged("numbers are not finite");
    for (const mesh::Triangle& t : m.triangles)
        for (std::uint32_t v : t)
            if (v >= vertices) return damaged("a triangle names a vertex that is not there");
    for (std::size_t t = 0; t < m.triangles.size(); ++t)
        if (mesh::material_of(m, t) >= model.materials.size())
            return damaged("a triangle names a material that is not there");
    for (const mesh::Material& material : model.materials)
        for (const mesh::TextureReference* texture :
             {&material.base_color_texture, &material.metallic_roughness_texture, &material.occlusion_texture,
              &material.emissive_texture})
            if (texture->image >= static_cast<int>(model.images.size()))
                return damaged("a material names an image that is not there");
    return Nothing{};
}

}  // namespace

std::vector<std::byte> serialize(const BakedModel& baked) {
    Writer writer;
    writer.raw(magic, magic_bytes);
    describe_all(writer, baked);
    return std::move(writer.bytes);
}

Result<BakedModel> deserialize(std::span<const std::byte> bytes) {
    Reader reader(bytes);
    char found[magic_bytes] = {};
    reader.raw(found, magic_bytes);
    if (!reader.ok() || std::memcmp(found, magic, magic_bytes) != 0) return damaged("it does not start with LODBAKE1");
    BakedModel baked;
    describe_all(reader, baked);
    if (!reader.ok()) return damaged("it ends too early");
    if (!reader.at_end()) return damaged("bytes follow its end");
    if (Status valid = validate(baked.model); !valid) return valid.error();
    const mesh::Mesh& m = baked.model.mesh;
    if (Status valid = simplify::validate(baked.history, m.positions.size(), m.triangles.size()); !valid)
        return valid.error();
    return baked;
}

}  // namespace lodestream::bake
