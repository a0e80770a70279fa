#include "server/importer/gltf_accessor.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <cstring>

namespace lodestream::importer {

struct GltfAccessors::Layout {
    std::string name;  // for messages: "accessor 3 (POSITION)"
    int component_type = 0;
    int components = 0;
    std::size_t component_bytes = 0;
    std::size_t count = 0;
    std::size_t element_bytes() const { return component_bytes * static_cast<std::size_t>(components); }
};

namespace {

constexpr std::uint64_t max_meshopt_ratio = 64;  // its vertex codec spends at least two bits on sixteen bytes
constexpr std::size_t max_meshopt_stride = 256;

bool fits(std::uint64_t offset, std::uint64_t length, std::uint64_t size) {
    return offset <= size && length <= size - offset;
}

template <class T>
T load(const std::byte* at) {
    T value;
    std::memcpy(&value, at, sizeof value);
    return value;
}

std::uint32_t load_index(const std::byte* at, int component_type) {
    switch (component_type) {
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
            return load<std::uint8_t>(at);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
            return load<std::uint16_t>(at);
        default:
            return load<std::uint32_t>(at);
    }
}

bool is_index_type(int component_type) {
    return component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
           component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
           component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
}

float load_float(const std::byte* at, int component_type, bool normalized) {
    const auto scaled = [normalized](float value, float largest) {
        return normalized ? std::max(value / largest, -1.0f) : value;
    };
    switch (component_type) {
        case TINYGLTF_COMPONENT_TYPE_BYTE:
            return scaled(load<std::int8_t>(at), 127);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
            return scaled(load<std::uint8_t>(at), 255);
        case TINYGLTF_COMPONENT_TYPE_SHORT:
            return scaled(load<std::int16_t>(at), 32767);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
            return scaled(load<std::uint16_t>(at), 65535);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
            return static_cast<float>(load<std::uint32_t>(at));
        default:
            return load<float>(at);
    }
}

std::size_t component_bytes(int component_type) {
    switch (component_type) {
        case TINYGLTF_COMPONENT_TYPE_BYTE:
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
            return 1;
        case TINYGLTF_COMPONENT_TYPE_SHORT:
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
            return 2;
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
        case TINYGLTF_COMPONENT_TYPE_FLOAT:
            return 4;
        default:
            return 0;
    }
}

int component_count(int type) {
    switch (type) {
        case TINYGLTF_TYPE_SCALAR:
            return 1;
        case TINYGLTF_TYPE_VEC2:
            return 2;
        case TINYGLTF_TYPE_VEC3:
            return 3;
        case TINYGLTF_TYPE_VEC4:
            return 4;
        case TINYGLTF_TYPE_MAT4:
            return 16;
        default:
            return 0;
    }
}

// A member of an extension as a whole number; `otherwise` where it is missing or none.
std::uint64_t member(const tinygltf::Value& object, const char* key, std::uint64_t otherwise) {
    if (!object.Has(key) || !object.Get(key).IsNumber()) return otherwise;
    const double value = object.Get(key).GetNumberAsDouble();
    return value >= 0 && value < 9e15 ? static_cast<std::uint64_t>(value) : otherwise;
}

std::string text_member(const tinygltf::Value& object, const char* key) {
    return object.Has(key) && object.Get(key).IsString() ? object.Get(key).Get<std::string>() : std::string();
}

// Filters run in place on elements of these sizes only; the decoder asserts them.
bool apply_filter(const std::string& filter, std::vector<std::byte>& data, std::size_t count, std::size_t stride) {
    if (filter.empty() || filter == "NONE") return true;
    if (filter == "OCTAHEDRAL" && (stride == 4 || stride == 8))
        meshopt_decodeFilterOct(data.data(), count, stride);
    else if (filter == "QUATERNION" && stride == 8)
        meshopt_decodeFilterQuat(data.data(), count, stride);
    else if (filter == "EXPONENTIAL" && stride % 4 == 0)
        meshopt_decodeFilterExp(data.data(), count, stride);
    else
        return false;
    return true;
}

// Whether stride and count are ones that the codec of this mode takes; it asserts them.
bool is_valid_mode(const std::string& mode, std::size_t stride, std::uint64_t count) {
    if (mode == "ATTRIBUTES") return stride > 0 && stride <= max_meshopt_stride && stride % 4 == 0;
    if (mode == "TRIANGLES") return (stride == 2 || stride == 4) && count % 3 == 0;
    if (mode == "INDICES") return stride == 2 || stride == 4;
    return false;
}

int decode_mode(const std::string& mode, std::vector<std::byte>& to, std::size_t count, std::size_t stride,
                std::span<const std::byte> from) {
    const auto* bytes = reinterpret_cast<const unsigned char*>(from.data());
    if (mode == "ATTRIBUTES") return meshopt_decodeVertexBuffer(to.data(), count, stride, bytes, from.size());
    if (mode == "TRIANGLES") return meshopt_decodeIndexBuffer(to.data(), count, stride, bytes, from.size());
    return meshopt_decodeIndexSequence(to.data(), count, stride, bytes, from.size());
}

}  // namespace

GltfAccessors::GltfAccessors(const GltfDocument& document, const Limits& limits)
    : document_(document), limits_(limits) {
    for (const GltfBuffer& buffer : document.buffers) buffer_bytes_ += buffer.bytes.size();
}

Result<std::vector<std::byte>> GltfAccessors::decompress(int index, const tinygltf::Value& extension) {
    const std::string name = "buffer view " + std::to_string(index) + " (meshopt)";
    constexpr std::uint64_t missing = ~std::uint64_t{0};
    const std::uint64_t buffer = member(extension, "buffer", missing), offset = member(extension, "byteOffset", 0);
    const std::uint64_t length = member(extension, "byteLength", missing), count = member(extension, "count", missing);
    const std::uint64_t stride = member(extension, "byteStride", missing);
    const std::string mode = text_member(extension, "mode");
    if (buffer >= document_.buffers.size() || !fits(offset, length, document_.buffers[buffer].bytes.size()))
        return invalid_input(name + " lies outside its buffer");
    if (count == missing || stride > max_meshopt_stride || !is_valid_mode(mode, stride, count))
        return invalid_input(name + " states no valid mode, count and stride");
    const std::span<const std::byte> from = document_.buffers[buffer].bytes.subspan(offset, length);
    if (count > (max_meshopt_ratio * from.size()) / stride)
        return invalid_input(name + " states more than it can hold");
    if (count == 0) return std::vector<std::byte>{};
    decompressed_bytes_ += count * stride;
    if (decompressed_bytes_ > limits_.file_bytes)
        return fail(ErrorCode::limit_exceeded, name + ": views decompress to more bytes than the limit");
    std::vector<std::byte> to(count * stride);
    if (decode_mode(mode, to, count, stride, from) != 0) return invalid_input(name + " is damaged");
    if (!apply_filter(text_member(extension, "filter"), to, count, stride))
        return invalid_input(name + " states a filter that its elements do not fit");
    return to;
}

Result<std::span<const std::byte>> GltfAccessors::view(int index) {
    if (index < 0 || static_cast<std::size_t>(index) >= document_.json.bufferViews.size())
        return invalid_input("buffer view " + std::to_string(index) + " does not exist");
    const tinygltf::BufferView& view = document_.json.bufferViews[static_cast<std::size_t>(index)];
    const auto extension = view.extensions.find("EXT_meshopt_compression");
    if (extension != view.extensions.end()) {
        const auto known = decompressed_.find(index);
        if (known != decompressed_.end()) return std::span<const std::byte>(known->second);
        Result<std::vector<std::byte>> bytes = decompress(index, extension->second);
        if (!bytes) return bytes.error();
        return std::span<const std::byte>(decompressed_.emplace(index, std::move(*bytes)).first->second);
    }
    if (view.buffer < 0 || static_cast<std::size_t>(view.buffer) >= document_.buffers.size())
        return invalid_input("buffer view " + std::to_string(index) + " names a buffer that does not exist");
    const GltfBuffer& buffer = document_.buffers[static_cast<std::size_t>(view.buffer)];
    if (buffer.is_placeholder || !fits(view.byteOffset, view.byteLength, buffer.bytes.size()))
        return invalid_input("buffer view " + std::to_string(index) + " lies outside its buffer");
    return buffer.bytes.subspan(view.byteOffset, view.byteLength);
}

Result<GltfAccessors::Layout> GltfAccessors::layout_of(int accessor, std::uint64_t max_count,
                                                       const std::string& what) const {
    Layout layout;
    layout.name = "accessor " + std::to_string(accessor) + " (" + what + ")";
    if (accessor < 0 || static_cast<std::size_t>(accessor) >= document_.json.accessors.size())
        return invalid_input(layout.name + " does not exist");
    const tinygltf::Accessor& a = document_.json.accessors[static_cast<std::size_t>(accessor)];
    layout.component_type = a.componentType;
    layout.components = component_count(a.type);
    layout.component_bytes = component_bytes(a.componentType);
    layout.count = a.count;
    if (layout.components == 0 || layout.component_bytes == 0)
        return invalid_input(layout.name + " is of a type that glTF does not allow there");
    if (a.count > max_count)
        return fail(ErrorCode::limit_exceeded,
                    layout.name + " has " + std::to_string(a.count) + " elements, more than the limit");
    return layout;
}

Status GltfAccessors::copy_elements(int view_index, std::uint64_t offset, std::uint64_t count, const Layout& layout,
                                    bool strided, std::vector<std::byte>& to) {
    const Result<std::span<const std::byte>> bytes = view(view_index);
    if (!bytes) return fail(bytes.error().code, layout.name + ": " + bytes.error().message);
    if (count == 0) return Nothing{};
    const std::size_t size = layout.element_bytes();
    const std::size_t stated = document_.json.bufferViews[static_cast<std::size_t>(view_index)].byteStride;
    const std::size_t stride = strided && stated > 0 ? stated : size;
    if (stride < size) return invalid_input(layout.name + " has elements larger than their stride");
    if (!fits(offset, (count - 1) * stride + size, bytes->size()))
        return invalid_input(layout.name + " reaches beyond its buffer view");
    to.resize(count * size);
    const std::byte* from = bytes->data() + offset;
    for (std::uint64_t i = 0; i < count; ++i) std::memcpy(to.data() + i * size, from + i * stride, size);
    return Nothing{};
}

Status GltfAccessors::apply_sparse(int accessor, const Layout& layout, std::vector<std::byte>& elements) {
    const auto& sparse = document_.json.accessors[static_cast<std::size_t>(accessor)].sparse;
    if (sparse.count < 0 || static_cast<std::size_t>(sparse.count) > layout.count || sparse.indices.byteOffset < 0 ||
        sparse.values.byteOffset < 0 || !is_index_type(sparse.indices.componentType))
        return invalid_input(layout.name + " has an invalid sparse part");
    const auto count = static_cast<std::uint64_t>(sparse.count);
    Layout of_indices{layout.name + " sparse indices", sparse.indices.componentType, 1,
                      component_bytes(sparse.indices.componentType), count};
    std::vector<std::byte> indices, values;
    const auto offset = [](int bytes) { return static_cast<std::uint64_t>(bytes); };
    Status read =
        copy_elements(sparse.indices.bufferView, offset(sparse.indices.byteOffset), count, of_indices, false, indices);
    if (!read) return read;
    read = copy_elements(sparse.values.bufferView, offset(sparse.values.byteOffset), count, layout, false, values);
    if (!read) return read;
    const std::size_t size = layout.element_bytes();
    for (std::uint64_t i = 0; i < count; ++i) {
        const std::uint32_t at = load_index(indices.data() + i * of_indices.component_bytes, of_indices.component_type);
        if (at >= layout.count) return invalid_input(layout.name + " has a sparse index out of range");
        std::memcpy(elements.data() + at * size, values.data() + i * size, size);
    }
    return Nothing{};
}

// The elements one after another, zero where the accessor has no view.
Result<std::vector<std::byte>> GltfAccessors::packed(int accessor, const Layout& layout) {
    const tinygltf::Accessor& a = document_.json.accessors[static_cast<std::size_t>(accessor)];
    std::vector<std::byte> elements;
    if (a.bufferView >= 0) {
        if (const Status read = copy_elements(a.bufferView, a.byteOffset, layout.count, layout, true, elements); !read)
            return read.error();
    } else if (layout.count <= buffer_bytes_) {
        elements.resize(layout.count * layout.element_bytes());
    } else {
        return invalid_input(layout.name + " has no data and more elements than the file has bytes");
    }
    if (a.sparse.isSparse)
        if (const Status applied = apply_sparse(accessor, layout, elements); !applied) return applied.error();
    return elements;
}

Result<GltfAccessors::Floats> GltfAccessors::floats(int accessor, int least, int most, std::size_t count,
                                                    const std::string& what) {
    const Result<Layout> layout = layout_of(accessor, limits_.vertices, what);
    if (!layout) return layout.error();
    if (layout->components < least || layout->components > most)
        return invalid_input(layout->name + " is of a type that glTF does not allow there");
    if (count != any_count && layout->count != count)
        return invalid_input(layout->name + " has " + std::to_string(layout->count) + " elements where " +
                             std::to_string(count) + " are needed");
    const Result<std::vector<std::byte>> elements = packed(accessor, *layout);
    if (!elements) return elements.error();
    const bool normalized = document_.json.accessors[static_cast<std::size_t>(accessor)].normalized;
    Floats floats{layout->count, layout->components, {}};
    floats.values.resize(layout->count * static_cast<std::size_t>(layout->components));
    for (std::size_t i = 0; i < floats.values.size(); ++i)
        floats.values[i] =
            load_float(elements->data() + i * layout->component_bytes, layout->component_type, normalized);
    return floats;
}

Result<std::vector<std::uint32_t>> GltfAccessors::indices(int accessor) {
    const Result<Layout> layout = layout_of(accessor, 3 * limits_.triangles, "indices");
    if (!layout) return layout.error();
    if (layout->components != 1 || !is_index_type(layout->component_type))
        return invalid_input(layout->name + " is of a type that glTF does not allow there");
    const Result<std::vector<std::byte>> elements = packed(accessor, *layout);
    if (!elements) return elements.error();
    std::vector<std::uint32_t> indices(layout->count);
    for (std::size_t i = 0; i < indices.size(); ++i)
        indices[i] = load_index(elements->data() + i * layout->component_bytes, layout->component_type);
    return indices;
}

}  // namespace lodestream::importer
