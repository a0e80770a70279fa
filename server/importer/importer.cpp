#include "server/importer/importer.h"

#include <algorithm>
#include <exception>
#include <new>
#include <utility>

#include "common/codec/draco_mesh.h"
#include "server/importer/formats.h"
#include "server/importer/printable.h"
#include "server/importer/soup.h"
#include "server/importer/text_cursor.h"
#include "server/importer/whole_file.h"

namespace lodestream::importer {
namespace {

constexpr std::pair<const char*, Format> extensions[] = {
    {".gltf", Format::gltf},       {".glb", Format::glb},         {".obj", Format::obj}, {".ply", Format::ply},
    {".stl", Format::stl},         {".off", Format::off},         {".drc", Format::drc}, {".png", Format::terrain_png},
    {".hgt", Format::terrain_hgt}, {".asc", Format::terrain_asc},
};

constexpr std::size_t sniffed_bytes = 64 << 10;  // of a text file whose head is all comments
constexpr std::size_t stl_header_bytes = 84, stl_facet_bytes = 50;
constexpr std::size_t hgt_sizes[] = {1201 * 1201 * 2, 3601 * 3601 * 2};

bool is_binary_stl(std::span<const std::byte> bytes) {
    if (bytes.size() < stl_header_bytes) return false;
    std::uint64_t facets = 0;
    for (int i = 3; i >= 0; --i)
        facets = facets << 8 | std::to_integer<std::uint64_t>(bytes[80 + static_cast<std::size_t>(i)]);
    return facets > 0 && bytes.size() == stl_header_bytes + stl_facet_bytes * facets;
}

std::string_view first_word(std::string_view text) {
    TextCursor cursor(text.substr(0, sniffed_bytes), '#');
    return cursor.find_word() ? cursor.word() : std::string_view{};
}

bool is_one_of(std::string_view word, std::initializer_list<std::string_view> words) {
    return std::find(words.begin(), words.end(), word) != words.end();
}

using Reader = Status (*)(const Source&, Soup&);

Reader reader_of(Format format) {
    switch (format) {
        case Format::gltf:
            return read_gltf;
        case Format::glb:
            return read_glb;
        case Format::obj:
            return read_obj;
        case Format::ply:
            return read_ply;
        case Format::stl:
            return read_stl;
        case Format::off:
            return read_off;
        case Format::drc:
            return read_drc;
        case Format::terrain_png:
            return read_terrain_png;
        case Format::terrain_hgt:
            return read_terrain_hgt;
        case Format::terrain_asc:
            return read_terrain_asc;
    }
    return read_obj;
}

Result<mesh::Model> import_source(const Source& source, Format format) {
    try {
        if (source.bytes.size() > source.limits.file_bytes)
            return fail(ErrorCode::limit_exceeded, "has " + std::to_string(source.bytes.size()) +
                                                       " bytes, more than the limit of " +
                                                       std::to_string(source.limits.file_bytes));
        if (source.bytes.empty()) return invalid_input("is empty");
        Soup soup;
        if (const Status read = reader_of(format)(source, soup); !read) return read.error();
        return finish(std::move(soup), source.limits);
    } catch (const std::bad_alloc&) {
        return fail(ErrorCode::limit_exceeded, "needs more memory than there is");
    } catch (const std::exception& e) {
        return invalid_input(std::string("cannot be read: ") + e.what());
    }
}

Result<mesh::Model> import_in_context(const Source& source, Format format, const std::string& name) {
    Result<mesh::Model> result = import_source(source, format);
    if (!result) return fail(result.error().code, printable(name + ": " + result.error().message));
    return result;
}

}  // namespace

Result<Format> format_of_extension(const std::filesystem::path& file) {
    const std::string extension = lower_case(file.extension().string());
    for (const auto& [known, format] : extensions)
        if (extension == known) return format;
    const std::string name = file.filename().string();
    return fail(ErrorCode::unsupported, name + (extension.empty() ? ": a file without an extension"
                                                                  : ": files of this type are not supported"));
}

Result<Format> sniff_format(std::span<const std::byte> bytes) {
    std::string_view text = as_text(bytes);
    if (text.starts_with("glTF")) return Format::glb;
    if (text.starts_with("DRACO")) return Format::drc;
    if (text.starts_with("\x89PNG\r\n")) return Format::terrain_png;
    if (is_binary_stl(bytes)) return Format::stl;
    if (std::find(std::begin(hgt_sizes), std::end(hgt_sizes), bytes.size()) != std::end(hgt_sizes))
        return Format::terrain_hgt;
    if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);

    const std::string word = lower_case(first_word(text));
    if (word.starts_with("{")) return Format::gltf;
    if (word == "ply") return Format::ply;
    if (word == "solid") return Format::stl;
    if (word.ends_with("off")) return Format::off;
    if (is_one_of(word, {"ncols", "nrows"})) return Format::terrain_asc;
    if (is_one_of(word, {"v", "vn", "vt", "vp", "f", "o", "g", "s", "l", "p", "mtllib", "usemtl"})) return Format::obj;
    return fail(ErrorCode::unsupported, "the content is of no supported format");
}

Status read_drc(const Source& source, Soup& soup) {
    const Limits& limits = source.limits;
    Result<codec::DracoMesh> decoded = codec::decode_draco(source.bytes, limits.vertices, limits.triangles);
    if (!decoded) return decoded.error();
    using Semantic = codec::DracoAttribute::Semantic;
    const auto values_of = [&](Semantic semantic, int least) -> const codec::DracoAttribute* {
        for (const auto& [id, attribute] : decoded->attributes)
            if (attribute.semantic == semantic && attribute.components >= least &&
                attribute.values.size() >= static_cast<std::size_t>(attribute.components) * decoded->points)
                return &attribute;
        return nullptr;
    };
    const codec::DracoAttribute* positions = values_of(Semantic::position, 3);
    if (!positions) return invalid_input("has no positions");
    const codec::DracoAttribute* normals = values_of(Semantic::normal, 3);
    const codec::DracoAttribute* coordinates = values_of(Semantic::texture_coordinate, 2);
    const codec::DracoAttribute* colors = values_of(Semantic::color, 3);
    for (std::uint32_t v = 0; v < decoded->points; ++v) {
        const auto at = [v](const codec::DracoAttribute* a) {
            return a->values.data() + std::size_t{v} * static_cast<std::size_t>(a->components);
        };
        const float* p = at(positions);
        soup.add_vertex({p[0], p[1], p[2]});
        if (normals) soup.set_normal(v, {at(normals)[0], at(normals)[1], at(normals)[2]});
        // Draco's own encoder takes them from OBJ and PLY files, whose images begin at the lower left.
        if (coordinates) soup.set_texture_coordinate(v, {at(coordinates)[0], 1 - at(coordinates)[1]});
        if (colors) {
            const float* c = at(colors);
            soup.set_color(v, linear_from_srgb(Vec4f{c[0], c[1], c[2], colors->components > 3 ? c[3] : 1.0f}));
        }
    }
    for (const mesh::Triangle& t : decoded->triangles)
        if (std::all_of(t.begin(), t.end(), [&](std::uint32_t v) { return v < decoded->points; }))
            soup.add_triangle(t);
        else
            ++soup.out_of_range_faces;
    return Nothing{};
}

Result<mesh::Model> import_model(std::span<const std::byte> bytes, Format format, const SideFiles& side_files,
                                 const Limits& limits) {
    return import_in_context({bytes, side_files, limits, {}}, format, "model");
}

Result<mesh::Model> import_file(const std::filesystem::path& file, const Limits& limits) {
    const std::string name = file.filename().string();
    try {
        const Result<Format> format = format_of_extension(file);
        if (!format) return format.error();
        const Result<std::vector<std::byte>> bytes = read_whole_file(file, limits.file_bytes);
        if (!bytes) return bytes.error();
        const SideFiles side_files = read_files_below(file.parent_path(), limits.file_bytes);
        return import_in_context({*bytes, side_files, limits, file.stem().string()}, *format, name);
    } catch (const std::bad_alloc&) {
        return fail(ErrorCode::limit_exceeded, name + ": needs more memory than there is");
    } catch (const std::exception& e) {
        return fail(ErrorCode::io, name + ": " + e.what());
    }
}

}  // namespace lodestream::importer
