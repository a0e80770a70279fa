// The stored form of a baked model, little-endian:
//   magic "LODBAKE2", then the fields below in order. A vector is its element count (u64) and its elements; a string
//   its byte count (u64) and its bytes. Arrays of the history begin at the next multiple of 8 after their count, so
//   that they can be used where they lie.
#include "server/bake/baked_model.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <type_traits>

#include "common/mesh/operations.h"

namespace lodestream::bake {

static_assert(std::endian::native == std::endian::little,
              "the stored form is the memory's on little-endian machines only");

namespace {

constexpr char magic[] = "LODBAKE2";
constexpr std::size_t magic_bytes = sizeof(magic) - 1;
constexpr std::size_t array_alignment = 8;

// Whether the memory of a T is the same for equal values: it has no gaps.
template <class T>
inline constexpr bool has_plain_bytes = std::is_trivially_copyable_v<T> && !std::is_same_v<T, texture::ImageUse>;

constexpr std::size_t padding(std::size_t size) {
    return (array_alignment - size % array_alignment) % array_alignment;
}

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
        if constexpr (has_plain_bytes<T>) {
            raw(values.data(), values.size() * sizeof(T));
        } else {
            for (const T& value : values) describe(*this, value);
        }
    }
    void operator()(const std::string& text) {
        (*this)(static_cast<std::uint64_t>(text.size()));
        raw(text.data(), text.size());
    }
    template <class T>
    void array(const std::vector<T>& values) {
        (*this)(static_cast<std::uint64_t>(values.size()));
        bytes.resize(bytes.size() + padding(bytes.size()));
        raw(values.data(), values.size() * sizeof(T));
    }
};

// Reads what Writer wrote; after the first shortage every read gives nothing and ok() is false.
class Reader {
  public:
    explicit Reader(std::span<const std::byte> bytes) : size_(bytes.size()), rest_(bytes) {}

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
        const std::size_t count = read_count(has_plain_bytes<T> ? sizeof(T) : 1);
        values.resize(count);
        if constexpr (has_plain_bytes<T>) {
            raw(values.data(), count * sizeof(T));
        } else {
            for (T& value : values) describe(*this, value);
        }
    }
    void operator()(std::string& text) {
        text.resize(read_count(1));
        raw(text.data(), text.size());
    }
    template <class T>
    void array(std::span<const T>& values) {
        static_assert(alignof(T) <= array_alignment && std::is_trivially_copyable_v<T>);
        const std::size_t count = read_count(sizeof(T)), skip = padding(size_ - rest_.size());
        if (!ok_ || skip + count * sizeof(T) > rest_.size()) {
            ok_ = false;
            return;
        }
        values = {reinterpret_cast<const T*>(rest_.data() + skip), count};
        rest_ = rest_.subspan(skip + count * sizeof(T));
    }

  private:
    // A count that the bytes at hand can hold, so that a damaged one cannot make an allocation of its own size.
    std::size_t read_count(std::size_t element_bytes) {
        std::uint64_t count = 0;
        (*this)(count);
        if (count > rest_.size() / element_bytes) ok_ = false;
        return ok_ ? static_cast<std::size_t>(count) : 0;
    }

    std::size_t size_;
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

template <class Stream, class Use>
requires std::is_same_v<std::remove_const_t<Use>, texture::ImageUse>
void describe(Stream& stream, Use& use) {
    stream(use.is_used);
    stream(use.content);
    stream(use.reads_alpha);
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
    stream(model.materials);
    stream(model.images);
    stream(model.origin);
    stream(model.kind);
    stream(model.objects);
    stream(baked.bounds);
    stream(baked.grid_bounds);
    stream(baked.image_uses);
    stream(baked.texel_sizes);
    stream(baked.errors);
    auto& history = baked.history;
    stream.array(history.steps);
    stream.array(history.positions);
    stream.array(history.normals);
    stream.array(history.texture_coordinates);
    stream.array(history.colors);
    stream.array(history.changed_vertices);
    stream.array(history.corner_moves);
    stream.array(history.triangles);
    stream.array(history.triangle_materials);
}

Error damaged(const std::string& what) {
    return fail(ErrorCode::invalid_input, "baked model is damaged: " + what);
}

bool finite(const Box& box) {
    return all_finite(box.min) && all_finite(box.max);
}

Status validate_materials(const BakedView& baked) {
    const mesh::Model& model = baked.model;
    for (const std::uint32_t material : baked.history.triangle_materials)
        if (material >= model.materials.size()) return damaged("a triangle names a material that is not there");
    if (model.materials.empty()) return damaged("it has no material");
    for (const mesh::Material& material : model.materials)
        for (const mesh::TextureReference* texture :
             {&material.base_color_texture, &material.metallic_roughness_texture, &material.occlusion_texture,
              &material.emissive_texture})
            if (texture->image >= static_cast<int>(model.images.size()))
                return damaged("a material names an image that is not there");
    if (baked.image_uses.size() != model.images.size() || baked.texel_sizes.size() != model.images.size())
        return damaged("image counts differ");
    return Nothing{};
}

Status validate_errors(const std::vector<ErrorSample>& errors) {
    if (errors.empty()) return damaged("it has no measured error");
    for (std::size_t i = 0; i < errors.size(); ++i) {
        const ErrorSample& sample = errors[i];
        if (!std::isfinite(sample.error.rms) || !std::isfinite(sample.error.max) || sample.error.rms < 0)
            return damaged("an error is no number");
        if (i > 0 && sample.triangles >= errors[i - 1].triangles) return damaged("its errors are not in order");
    }
    return Nothing{};
}

Status validate(const BakedView& baked) {
    if (!all_finite(baked.model.origin) || !finite(baked.bounds) || !finite(baked.grid_bounds))
        return damaged("numbers are not finite");
    if (baked.history.steps.empty()) return damaged("it has no level");
    if (Status valid = validate_errors(baked.errors); !valid) return valid.error();
    if (Status valid = simplify::validate(baked.history); !valid) return damaged(valid.error().message);
    return validate_materials(baked);
}

}  // namespace

BakedModel make_baked_model(mesh::Model model, simplify::History history) {
    BakedModel baked;
    baked.bounds = mesh::bounds(model.mesh);
    for (const Vec3f& p : history.positions) baked.grid_bounds.add(Vec3d(p));
    baked.image_uses = texture::image_uses(model);
    baked.texel_sizes = texture::texel_sizes(model);
    baked.model = std::move(model);
    baked.model.mesh = {};
    baked.history = std::move(history);
    return baked;
}

std::vector<std::byte> serialize(const BakedModel& baked) {
    Writer writer;
    writer.raw(magic, magic_bytes);
    describe_all(writer, baked);
    return std::move(writer.bytes);
}

Result<BakedView> open_baked_model(std::span<const std::byte> bytes) {
    Reader reader(bytes);
    char found[magic_bytes] = {};
    reader.raw(found, magic_bytes);
    if (!reader.ok() || std::memcmp(found, magic, magic_bytes) != 0) return damaged("it does not start with LODBAKE2");
    BakedView baked;
    describe_all(reader, baked);
    if (!reader.ok()) return damaged("it ends too early");
    if (!reader.at_end()) return damaged("bytes follow its end");
    if (Status valid = validate(baked); !valid) return valid.error();
    return baked;
}

metric::SurfaceError error_of(std::span<const ErrorSample> errors, std::uint64_t triangles) {
    // The first sample that is not finer.
    const auto coarser = std::lower_bound(errors.begin(), errors.end(), triangles,
                                          [](const ErrorSample& s, std::uint64_t n) { return s.triangles > n; });
    if (coarser == errors.end()) return errors.back().error;
    if (coarser->triangles == triangles || coarser == errors.begin()) return coarser->error;
    const ErrorSample& finer = *(coarser - 1);
    if (!(finer.error.rms > 0) || coarser->triangles == 0) return coarser->error;
    const auto logarithm = [](std::uint64_t n) { return std::log(static_cast<double>(n)); };
    const double share = (logarithm(finer.triangles) - logarithm(triangles)) /
                         (logarithm(finer.triangles) - logarithm(coarser->triangles));
    return {finer.error.rms * std::pow(coarser->error.rms / finer.error.rms, share), coarser->error.max};
}

}  // namespace lodestream::bake
