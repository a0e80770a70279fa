// How the folder's stored forms are written and read, little-endian: a vector is its element count (u64) and its
// elements, a string its byte count (u64) and its bytes, an array begins at the next multiple of 8 after its count, so
// that it can be used where it lies. Private to the folder.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "common/mesh/mesh.h"
#include "common/texture/use.h"
#include "server/bake/baked_model.h"

namespace lodestream::bake {

static_assert(std::endian::native == std::endian::little,
              "the stored form is the memory's on little-endian machines only");

inline constexpr std::size_t array_alignment = 8;

// Whether the memory of a T is the same for equal values: it has no gaps.
template <class T>
inline constexpr bool has_plain_bytes = std::is_trivially_copyable_v<T> && !std::is_same_v<T, texture::ImageUse>;

inline constexpr std::size_t padding(std::size_t size) {
    return (array_alignment - size % array_alignment) % array_alignment;
}

class Writer {
  public:
    std::vector<std::byte> bytes;

    void raw(const void* data, std::size_t size) {
        const auto* begin = static_cast<const std::byte*>(data);
        bytes.insert(bytes.end(), begin, begin + size);
    }
    void magic(std::string_view name) { raw(name.data(), name.size()); }
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
    // Whether it goes on with this; read either way.
    bool magic(std::string_view name) {
        std::string found(name.size(), '\0');
        raw(found.data(), found.size());
        return ok_ && found == name;
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

// Errors as they were stored before those of normals were measured.
inline void read_older_errors(Reader& reader, std::vector<ErrorSample>& errors) {
    struct Older {
        std::uint64_t triangles;
        double rms, max;
    };
    std::vector<Older> older;
    reader(older);
    for (const Older& sample : older) errors.push_back({sample.triangles, {sample.rms, sample.max}});
}

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

}  // namespace lodestream::bake
