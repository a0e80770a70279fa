#include <cmath>

#include "server/importer/formats.h"
#include "server/importer/text_cursor.h"

namespace lodestream::importer {
namespace {

struct Header {
    bool texture = false, color = false, normal = false;
    std::uint64_t vertices = 0, faces = 0;
};

// A whole number in [0, bytes left]: no count can be larger than the text that has to spell its items.
Result<std::uint64_t> read_count(TextCursor& cursor, const char* what) {
    const double value = cursor.find_word() ? cursor.number() : -1;
    if (!(value >= 0) || value != std::floor(value)) return invalid_input(std::string("states no count of ") + what);
    if (value > static_cast<double>(cursor.bytes_left()))
        return invalid_input(std::string("states more ") + what + " than its size allows");
    return static_cast<std::uint64_t>(value);
}

// "[ST][C][N]OFF"; the word itself may be missing.
Result<Header> read_header(TextCursor& cursor) {
    Header header;
    if (!cursor.find_word()) return invalid_input("has no geometry");
    TextCursor ahead = cursor;
    std::string word(ahead.word());
    if (word.ends_with("OFF") || word.ends_with("off")) {
        cursor = ahead;
        word.resize(word.size() - 3);
        const auto flag = [&word](const char* prefix) {
            const bool found = word.starts_with(prefix);
            if (found) word.erase(0, std::string_view(prefix).size());
            return found;
        };
        header.texture = flag("ST");
        header.color = flag("C");
        header.normal = flag("N");
        if (!word.empty()) return fail(ErrorCode::unsupported, "is OFF of the unsupported kind " + word + "OFF");
        TextCursor peek = cursor;
        if (peek.find_word() && peek.word() == "BINARY") return fail(ErrorCode::unsupported, "is binary OFF");
    }
    const Result<std::uint64_t> vertices = read_count(cursor, "vertices");
    if (!vertices) return vertices.error();
    const Result<std::uint64_t> faces = read_count(cursor, "faces");
    if (!faces) return faces.error();
    header.vertices = *vertices;
    header.faces = *faces;
    if (!cursor.at_line_end()) cursor.word();  // the count of edges, which nobody needs
    return header;
}

// The colour at the end of a line: 3 or 4 numbers, whole ones to 255, others to 1. False where there is none.
bool read_color(TextCursor& cursor, Rgba8& color) {
    double parts[4] = {0, 0, 0, -1};
    int count = 0;
    bool fractions = false;
    while (count < 4 && !cursor.at_line_end()) {
        const std::string_view word = cursor.word();
        fractions = fractions || word.find('.') != std::string_view::npos;
        parts[count++] = parse_number(word);
    }
    if (count < 3) return false;
    const double scale = fractions ? 1.0 : 1.0 / 255;
    if (count == 3) parts[3] = 1 / scale;
    color = linear_from_srgb(Vec4f(Vec4d{parts[0], parts[1], parts[2], parts[3]} * scale));
    return true;
}

void read_vertex(TextCursor& cursor, const Header& header, Soup& soup) {
    const double x = cursor.number(), y = cursor.number(), z = cursor.number();
    const std::uint32_t vertex = soup.add_vertex({x, y, z});
    if (header.normal) {
        const double nx = cursor.number(), ny = cursor.number(), nz = cursor.number();
        soup.set_normal(vertex, Vec3f(Vec3d{nx, ny, nz}));
    }
    Rgba8 color;
    if (header.color && !header.texture && read_color(cursor, color)) soup.set_color(vertex, color);
    if (header.texture && !header.color) {
        const double s = cursor.number(), t = cursor.number();
        soup.set_texture_coordinate(vertex, Vec2f(glm::dvec2{s, 1 - t}));
    }
}

void read_face(TextCursor& cursor, const Header& header, std::vector<std::uint32_t>& corners, Soup& soup) {
    const double count = cursor.number();
    corners.clear();
    bool in_range = true;
    for (double i = 0; i < count && !cursor.at_line_end(); ++i) {
        const double index = cursor.number();
        in_range = in_range && index >= 0 && index < static_cast<double>(header.vertices);
        if (in_range) corners.push_back(static_cast<std::uint32_t>(index));
    }
    if (!in_range) {
        ++soup.out_of_range_faces;
        return;
    }
    if (!(static_cast<double>(corners.size()) == count)) corners.clear();  // the line ended before
    Rgba8 color;
    if (!header.color && corners.size() > 2 && read_color(cursor, color))
        for (std::uint32_t& corner : corners) {
            corner = soup.copy_vertex(corner);
            soup.set_color(corner, color);
        }
    soup.add_polygon(corners);
}

}  // namespace

Status read_off(const Source& source, Soup& soup) {
    TextCursor cursor(as_text(source.bytes), '#');
    const Result<Header> header = read_header(cursor);
    if (!header) return header.error();
    if (const Status fits = admit(header->vertices, header->faces, source.limits); !fits) return fits;
    for (std::uint64_t i = 0; i < header->vertices; ++i) {
        if (!cursor.find_word())
            return invalid_input("states " + std::to_string(header->vertices) + " vertices but holds " +
                                 std::to_string(i));
        read_vertex(cursor, *header, soup);
        cursor.skip_line();
    }
    std::vector<std::uint32_t> corners;
    for (std::uint64_t i = 0; i < header->faces; ++i) {
        if (!cursor.find_word())
            return invalid_input("states " + std::to_string(header->faces) + " faces but holds " + std::to_string(i));
        read_face(cursor, *header, corners, soup);
        cursor.skip_line();
        if (soup.triangles.size() > source.limits.triangles)
            return admit(0, soup.triangles.size(), source.limits).error();
    }
    if (header->texture && header->color) soup.warn("colours and texture coordinates of STCOFF ignored");
    return Nothing{};
}

}  // namespace lodestream::importer
