#include <algorithm>
#include <cstring>

#include "server/importer/formats.h"
#include "server/importer/text_cursor.h"

// STL holds separate facets; their normals are ignored, as many writers leave them zero or wrong.
namespace lodestream::importer {
namespace {

constexpr std::size_t header_bytes = 84, facet_bytes = 50;
constexpr std::size_t text_head_bytes = 4096;  // where a text file shows its first facet

float little_endian_float(const std::byte* at) {
    std::uint32_t bits = 0;
    for (int i = 3; i >= 0; --i) bits = bits << 8 | std::to_integer<std::uint32_t>(at[i]);
    float value;
    std::memcpy(&value, &bits, sizeof value);
    return value;
}

std::uint32_t stated_facets(std::span<const std::byte> bytes) {
    std::uint32_t count = 0;
    for (std::size_t i = 4; i-- > 0;) count = count << 8 | std::to_integer<std::uint32_t>(bytes[80 + i]);
    return count;
}

// Binary files may begin with "solid" too, so the stated count decides, then the first words.
bool is_text(std::span<const std::byte> bytes) {
    if (bytes.size() >= header_bytes &&
        bytes.size() == header_bytes + facet_bytes * std::uint64_t{stated_facets(bytes)})
        return false;
    const std::string head = lower_case(as_text(bytes.first(std::min(bytes.size(), text_head_bytes))));
    TextCursor cursor(head);
    return cursor.find_word() && cursor.word() == "solid" &&
           (head.find("facet") != std::string::npos || head.find("endsolid") != std::string::npos);
}

Status read_binary(const Source& source, Soup& soup) {
    const std::span<const std::byte> bytes = source.bytes;
    if (bytes.size() < header_bytes) return invalid_input("is too short for an STL file");
    const std::uint64_t stated = stated_facets(bytes), held = (bytes.size() - header_bytes) / facet_bytes;
    if (stated > held)
        return invalid_input("states " + std::to_string(stated) + " facets but holds " + std::to_string(held));
    if (const Status fits = admit(0, stated, source.limits); !fits) return fits;
    if (bytes.size() > header_bytes + facet_bytes * stated) soup.warn("bytes after the last facet ignored");
    soup.positions.reserve(3 * stated);
    soup.triangles.reserve(stated);
    soup.triangle_materials.reserve(stated);
    for (std::uint64_t i = 0; i < stated; ++i) {
        const std::byte* corner = bytes.data() + header_bytes + facet_bytes * i + 12;
        mesh::Triangle triangle;
        for (std::uint32_t& v : triangle) {
            v = soup.add_vertex(
                {little_endian_float(corner), little_endian_float(corner + 4), little_endian_float(corner + 8)});
            corner += 12;
        }
        soup.add_triangle(triangle);
    }
    return Nothing{};
}

double number_on_any_line(TextCursor& cursor) {
    cursor.find_word();
    return cursor.number();
}

Status read_text(const Source& source, Soup& soup) {
    TextCursor cursor(as_text(source.bytes));
    std::vector<std::uint32_t> corners;
    std::uint32_t solids = 0;
    bool solid_has_facets = false;
    const auto end_facet = [&] {
        if (corners.empty()) return;
        if (!solid_has_facets) soup.object = solids++;
        solid_has_facets = true;
        soup.add_polygon(corners);
        corners.clear();
    };
    while (cursor.find_word()) {
        const std::string word = lower_case(cursor.word());
        if (word == "vertex") {
            const double x = number_on_any_line(cursor), y = number_on_any_line(cursor), z = number_on_any_line(cursor);
            corners.push_back(soup.add_vertex({x, y, z}));
        } else if (word == "solid" || word == "endsolid") {
            end_facet();
            solid_has_facets = false;
            cursor.skip_line();  // a name may hold any word
        } else if (word == "facet" || word == "endloop" || word == "endfacet") {
            end_facet();
            if (soup.triangles.size() > source.limits.triangles)
                return admit(0, soup.triangles.size(), source.limits).error();
        }
    }
    end_facet();
    soup.objects = solids;
    if (solids > 1) soup.kind = mesh::Kind::scene;
    return Nothing{};
}

}  // namespace

Status read_stl(const Source& source, Soup& soup) {
    return is_text(source.bytes) ? read_text(source, soup) : read_binary(source, soup);
}

}  // namespace lodestream::importer
