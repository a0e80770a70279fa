// tinygltf gives the typed model, but not the bytes: it refuses buffers longer than stated, buffers that an extension
// fills, and index accessors without a view, all legal, and it reads images without a check of their range. So those
// members are taken out of the JSON first and read here.
#define TINYGLTF_IMPLEMENTATION
#include "server/importer/gltf_document.h"

#include <algorithm>
#include <charconv>
#include <climits>

#include "server/importer/text_cursor.h"

namespace lodestream::importer {
namespace {

using Json = nlohmann::json;

constexpr int max_json_depth = 256;  // tinygltf and the JSON's destructor recurse

// tinygltf keeps a tree of about 200 bytes a value of what extensions hold; those handled here hold little.
constexpr std::size_t max_extension_members = 256;

// Extensions that change what is drawn little enough to be left out with a warning even where required.
constexpr std::string_view ignorable_prefixes[] = {
    "KHR_materials_",          "KHR_lights_",       "KHR_animation_",        "KHR_xmp",
    "EXT_structural_metadata", "EXT_mesh_features", "EXT_instance_features", "EXT_lights_"};
constexpr std::string_view handled_extensions[] = {"KHR_draco_mesh_compression", "EXT_meshopt_compression",
                                                   "KHR_mesh_quantization", "KHR_texture_transform",
                                                   "EXT_mesh_gpu_instancing"};

bool is_ignorable(const std::string& extension) {
    return std::any_of(std::begin(ignorable_prefixes), std::end(ignorable_prefixes),
                       [&](std::string_view prefix) { return extension.starts_with(prefix); });
}

bool is_too_deep(std::string_view json) {
    int depth = 0;
    bool in_string = false;
    for (std::size_t i = 0; i < json.size(); ++i) {
        const char c = json[i];
        if (in_string) {
            if (c == '\\')
                ++i;
            else if (c == '"')
                in_string = false;
        } else if (c == '"') {
            in_string = true;
        } else if (c == '{' || c == '[') {
            if (++depth > max_json_depth) return true;
        } else if (c == '}' || c == ']') {
            --depth;
        }
    }
    return false;
}

std::string string_of(const Json& object, const char* key) {
    const auto at = object.find(key);
    return at != object.end() && at->is_string() ? at->get<std::string>() : std::string();
}

std::int64_t integer_of(const Json& object, const char* key, std::int64_t otherwise) {
    const auto at = object.find(key);
    return at != object.end() && at->is_number_integer() ? at->get<std::int64_t>() : otherwise;
}

// Takes an array of objects out of the document.
Result<std::vector<Json>> take_objects(Json& document, const char* key) {
    const auto at = document.find(key);
    if (at == document.end()) return std::vector<Json>{};
    if (!at->is_array()) return invalid_input(std::string("\"") + key + "\" is not an array");
    std::vector<Json> objects;
    objects.reserve(at->size());
    for (Json& entry : *at) {
        if (!entry.is_object()) return invalid_input(std::string("\"") + key + "\" holds something other than objects");
        objects.push_back(std::move(entry));
    }
    document.erase(at);
    return objects;
}

std::string percent_decoded(const std::string& uri) {
    std::string out;
    for (std::size_t i = 0; i < uri.size(); ++i) {
        unsigned value = 0;
        const char* digits = uri.data() + i + 1;
        if (uri[i] == '%' && i + 2 < uri.size() && std::from_chars(digits, digits + 2, value, 16).ptr == digits + 2) {
            out += static_cast<char>(value);
            i += 2;
        } else {
            out += uri[i];
        }
    }
    return out;
}

bool is_data_uri(const std::string& uri) {
    return uri.starts_with("data:");
}

Result<std::vector<std::byte>> decode_data_uri(const std::string& uri) {
    constexpr std::string_view marker = ";base64,";
    const std::size_t comma = uri.find(',');
    if (comma == std::string::npos || comma + 1 < marker.size() ||
        std::string_view(uri).substr(comma + 1 - marker.size(), marker.size()) != marker)
        return invalid_input("has a data URI that is not base64");
    const std::string decoded = tinygltf::base64_decode(uri.substr(comma + 1));  // stops at the first bad character
    const auto* begin = reinterpret_cast<const std::byte*>(decoded.data());
    return std::vector<std::byte>(begin, begin + decoded.size());
}

bool is_placeholder(const Json& buffer) {
    const auto extensions = buffer.find("extensions");
    return extensions != buffer.end() && extensions->is_object() && extensions->contains("EXT_meshopt_compression");
}

Result<GltfBuffer> open_buffer(const Json& json, bool first, std::span<const std::byte> chunk, const Source& source) {
    GltfBuffer buffer;
    const std::int64_t stated = integer_of(json, "byteLength", -1);
    if (stated < 0) return invalid_input("states no byteLength");
    const auto length = static_cast<std::uint64_t>(stated);
    const std::string uri = string_of(json, "uri");
    if (uri.empty() && first && !chunk.empty()) {
        buffer.bytes = chunk;
    } else if (uri.empty()) {
        buffer.is_placeholder = is_placeholder(json);
        if (buffer.is_placeholder || length == 0) return buffer;
        return invalid_input("has neither a uri nor a binary chunk");
    } else {
        Result<std::vector<std::byte>> bytes =
            is_data_uri(uri) ? decode_data_uri(uri) : source.side_files(percent_decoded(uri));
        if (!bytes) return bytes.error();
        buffer.storage = std::move(*bytes);
        buffer.bytes = buffer.storage;
    }
    if (buffer.bytes.size() < length)
        return invalid_input("states " + std::to_string(length) + " bytes but holds " +
                             std::to_string(buffer.bytes.size()));
    buffer.bytes = buffer.bytes.first(length);
    return buffer;
}

Status open_buffers(const std::vector<Json>& objects, std::span<const std::byte> chunk, const Source& source,
                    std::vector<GltfBuffer>& buffers) {
    std::uint64_t total = 0;
    buffers.reserve(objects.size());  // the spans point into the storage of each
    for (std::size_t i = 0; i < objects.size(); ++i) {
        const std::string name = "buffer " + std::to_string(i);
        Result<GltfBuffer> buffer = open_buffer(objects[i], i == 0, chunk, source);
        if (!buffer) return fail(buffer.error().code, name + ": " + buffer.error().message);
        total += buffer->storage.size();
        if (total > source.limits.file_bytes)
            return fail(ErrorCode::limit_exceeded, name + ": buffers hold more bytes than the limit");
        buffers.push_back(std::move(*buffer));
    }
    return Nothing{};
}

GltfImage image_of(const Json& json, std::size_t index) {
    GltfImage image;
    const std::string uri = string_of(json, "uri");
    image.label = std::to_string(index);
    image.buffer_view = static_cast<int>(std::clamp<std::int64_t>(integer_of(json, "bufferView", -1), -1, INT_MAX));
    if (is_data_uri(uri)) {
        if (Result<std::vector<std::byte>> bytes = decode_data_uri(uri)) image.bytes = std::move(*bytes);
    } else if (!uri.empty()) {
        image.uri = percent_decoded(uri);
    }
    return image;
}

bool is_small(const Json& value) {
    if (!value.is_structured()) return true;
    return value.size() <= max_extension_members && std::all_of(value.begin(), value.end(), is_small);
}

// Takes out all that the importer does not look at, so that tinygltf need not copy it.
Status prune(Json& value) {
    if (value.is_object()) {
        value.erase("extras");
        const auto extensions = value.find("extensions");
        if (extensions != value.end() && extensions->is_object()) {
            for (auto member = extensions->begin(); member != extensions->end();)
                member = is_handled_gltf_extension(member.key()) ? std::next(member) : extensions->erase(member);
            if (!is_small(*extensions)) return invalid_input("has an extension with more members than it has use for");
        }
    }
    if (value.is_structured())
        for (Json& member : value)
            if (Status pruned = prune(member); !pruned) return pruned;
    return Nothing{};
}

// A Draco primitive carries its own indices, and its index accessor has no data, which tinygltf refuses.
void drop_draco_index_accessors(Json& document) {
    const auto meshes = document.find("meshes");
    if (meshes == document.end() || !meshes->is_array()) return;
    for (Json& mesh : *meshes) {
        if (!mesh.is_object() || !mesh.contains("primitives") || !mesh["primitives"].is_array()) continue;
        for (Json& primitive : mesh["primitives"]) {
            if (!primitive.is_object()) continue;
            const auto extensions = primitive.find("extensions");
            if (extensions != primitive.end() && extensions->is_object() &&
                extensions->contains("KHR_draco_mesh_compression"))
                primitive.erase("indices");
        }
    }
}

Status check_version(const Json& document) {
    const auto asset = document.find("asset");
    if (asset == document.end() || !asset->is_object()) return invalid_input("has no \"asset\", so it is no glTF");
    const std::string version = string_of(*asset, "version");
    if (version.empty()) return invalid_input("states no glTF version");
    if (!version.starts_with("2."))
        return fail(ErrorCode::unsupported, "is glTF " + version.substr(0, 16) + "; only 2.x is supported");
    return Nothing{};
}

Status check_required_extensions(const tinygltf::Model& model) {
    for (const std::string& extension : model.extensionsRequired)
        if (!is_handled_gltf_extension(extension) && !is_ignorable(extension))
            return fail(ErrorCode::unsupported, "requires the unsupported extension " + extension.substr(0, 64));
    return Nothing{};
}

std::string one_line(std::string text) {
    std::replace(text.begin(), text.end(), '\n', ' ');
    while (!text.empty() && text.back() == ' ') text.pop_back();
    return text;
}

Result<Json> parse_json(std::string_view text) {
    if (is_too_deep(text))
        return fail(ErrorCode::limit_exceeded, "has JSON nested deeper than " + std::to_string(max_json_depth));
    try {
        Json document = Json::parse(text);
        if (!document.is_object()) return invalid_input("is no JSON object");
        return document;
    } catch (const Json::parse_error& e) {
        return invalid_input("has a JSON syntax error at byte " + std::to_string(e.byte));
    } catch (const Json::exception& e) {
        return invalid_input("has JSON that cannot be read: " + one_line(e.what()));
    }
}

}  // namespace

bool is_handled_gltf_extension(const std::string& extension) {
    return std::find(std::begin(handled_extensions), std::end(handled_extensions), extension) !=
           std::end(handled_extensions);
}

Result<GltfDocument> open_gltf(std::span<const std::byte> json, std::span<const std::byte> binary_chunk,
                               const Source& source) {
    Result<Json> document = parse_json(as_text(json));
    if (!document) return document.error();
    if (const Status known = check_version(*document); !known) return known.error();

    GltfDocument opened;
    const Result<std::vector<Json>> buffers = take_objects(*document, "buffers");
    if (!buffers) return buffers.error();
    const Result<std::vector<Json>> images = take_objects(*document, "images");
    if (!images) return images.error();
    for (std::size_t i = 0; i < images->size(); ++i) opened.images.push_back(image_of((*images)[i], i));
    opened.has_animations = document->contains("animations");
    for (const char* unused : {"animations", "cameras"}) document->erase(unused);
    if (const Status pruned = prune(*document); !pruned) return pruned.error();
    drop_draco_index_accessors(*document);

    const std::string rest = document->dump(-1, ' ', false, Json::error_handler_t::replace);
    tinygltf::TinyGLTF loader;
    std::string error, warning;
    if (!loader.LoadASCIIFromString(&opened.json, &error, &warning, rest.data(), static_cast<unsigned>(rest.size()), "",
                                    tinygltf::NO_REQUIRE))
        return invalid_input(one_line(error.substr(0, error.find('\n'))));
    if (const Status handled = check_required_extensions(opened.json); !handled) return handled.error();
    if (const Status open = open_buffers(*buffers, binary_chunk, source, opened.buffers); !open) return open.error();
    return opened;
}

}  // namespace lodestream::importer
