// The lines of an OBJ file. tinyobjloader keeps at most 255 corners a polygon, gives up at the first index out of range
// and hands no colours to its callbacks, so only material libraries go through it (mtl.cpp).
#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <set>

#include "server/importer/formats.h"
#include "server/importer/text_cursor.h"

namespace lodestream::importer {
namespace {

struct Corner {
    std::int64_t position = 0, coordinate = 0, normal = 0;  // as in the file: from 1, negative from the end; 0: none
};

// "p", "p/t", "p//n" or "p/t/n".
bool parse_corner(std::string_view word, Corner& corner) {
    const char* at = word.data();
    const char* const end = at + word.size();
    std::int64_t* const fields[] = {&corner.position, &corner.coordinate, &corner.normal};
    for (std::int64_t* field : fields) {
        const auto [after, error] = std::from_chars(at, end, *field);
        if (error != std::errc{} && (error != std::errc::invalid_argument || field == fields[0])) return false;
        if (after == end) return true;
        if (*after != '/') return false;
        at = after + 1;
    }
    return false;
}

constexpr std::int64_t none = -1;

// The index from 0, `none` where the file names something that is not there.
std::int64_t resolved(std::int64_t index, std::size_t count) {
    const auto n = static_cast<std::int64_t>(count);
    if (index > 0 && index <= n) return index - 1;
    if (index < 0 && index >= -n) return n + index;
    return none;
}

class Reader {
  public:
    Reader(const Source& source, Soup& soup) : source_(source), soup_(soup) { soup.materials.emplace_back(); }

    Status read() {
        TextCursor cursor(as_text(source_.bytes), '#');
        while (cursor.find_word()) {
            const std::string_view keyword = cursor.word();
            if (keyword == "v")
                read_vertex(cursor);
            else if (keyword == "f")
                read_face(cursor);
            else if (keyword == "vn")
                normals_.emplace_back(read_vector(cursor));
            else if (keyword == "vt")
                read_coordinate(cursor);
            else if (keyword == "p" || keyword == "l")
                ++soup_.other_primitives;
            else
                read_statement(keyword, cursor);
            cursor.skip_line();
            if (soup_.triangles.size() > source_.limits.triangles || soup_.positions.size() > max_vertices())
                return admit(soup_.positions.size(), soup_.triangles.size(), source_.limits);
        }
        return finish();
    }

  private:
    // Corners with attributes are vertices of their own until the mesh is made compact.
    std::uint64_t max_vertices() const { return source_.limits.vertices + 3 * source_.limits.triangles; }

    static Vec3d read_vector(TextCursor& cursor) {
        const double x = cursor.number(), y = cursor.number(), z = cursor.number();
        return {x, y, z};
    }

    // x y z, then nothing, w, r g b or w r g b.
    void read_vertex(TextCursor& cursor) {
        const Vec3d position = read_vector(cursor);
        double extra[4];
        int count = 0;
        while (count < 4 && !cursor.at_line_end()) extra[count++] = cursor.number();
        places_.push_back(soup_.add_vertex(position));
        if (count < 3) return;
        const double* rgb = extra + (count - 3);
        colors_.resize(places_.size(), Vec3f{1});
        colors_.back() = Vec3f(Vec3d{rgb[0], rgb[1], rgb[2]});
    }

    // OBJ's images begin at the lower left, glTF's at the upper left.
    void read_coordinate(TextCursor& cursor) {
        const double u = cursor.number(), v = cursor.at_line_end() ? 0 : cursor.number();
        coordinates_.emplace_back(glm::dvec2{u, 1 - v});
    }

    void read_face(TextCursor& cursor) {
        corners_.clear();
        bool readable = true, in_range = true;
        while (!cursor.at_line_end()) {
            const std::string_view word = cursor.word();
            if (word == "\\") {  // the line goes on in the next
                cursor.skip_line();
                continue;
            }
            Corner corner;
            readable = readable && parse_corner(word, corner);
            const std::int64_t position = resolved(corner.position, places_.size());
            in_range = in_range && position != none;
            if (readable && in_range)
                corners_.push_back(vertex_of(places_[static_cast<std::size_t>(position)], corner));
        }
        if (!readable)
            ++soup_.unreadable_faces;
        else if (!in_range)
            ++soup_.out_of_range_faces;
        else
            add_face();
    }

    std::uint32_t vertex_of(std::uint32_t place, const Corner& corner) {
        const std::int64_t t = resolved(corner.coordinate, coordinates_.size());
        const std::int64_t n = resolved(corner.normal, normals_.size());
        if (t == none && n == none) return place;
        const std::uint32_t vertex = soup_.add_vertex(Vec3d(soup_.positions[place]));
        if (t != none) soup_.set_texture_coordinate(vertex, coordinates_[static_cast<std::size_t>(t)]);
        if (n != none) soup_.set_normal(vertex, normals_[static_cast<std::size_t>(n)]);
        if (place < colors_.size()) copies_.push_back({vertex, place});
        return vertex;
    }

    void add_face() {
        if (!object_has_faces_) soup_.object = objects_++;
        object_has_faces_ = true;
        soup_.add_polygon(corners_, material_);
    }

    void read_statement(std::string_view keyword, TextCursor& cursor) {
        if (keyword == "o" || keyword == "g") {
            object_has_faces_ = false;
        } else if (keyword == "usemtl") {
            use_material(std::string(TextCursor(cursor).rest_of_line()));
        } else if (keyword == "mtllib") {
            read_library(std::string(TextCursor(cursor).rest_of_line()));
        }
    }

    void use_material(const std::string& name) {
        const auto known = names_.find(name);
        if (known == names_.end()) undefined_.insert(name);
        material_ = known == names_.end() ? 0 : known->second;
    }

    void read_library(const std::string& name) {
        const auto first = static_cast<std::uint32_t>(soup_.materials.size());
        if (!libraries_.insert(name).second) return;
        read_mtl(source_, name, soup_);
        for (std::uint32_t m = first; m < soup_.materials.size(); ++m) names_.emplace(soup_.materials[m].name, m);
    }

    Status finish() {
        float largest = 0;
        for (const Vec3f& c : colors_) largest = std::max({largest, c.x, c.y, c.z});
        const float scale = largest > 1 ? 1.0f / 255 : 1.0f;  // some writers keep bytes
        for (std::size_t i = 0; i < colors_.size(); ++i)
            soup_.set_color(places_[i], linear_from_srgb(Vec4f{colors_[i] * scale, 1.0f}));
        for (const auto& [vertex, place] : copies_) soup_.set_color(vertex, Rgba8(soup_.colors[place]));
        if (!undefined_.empty())
            soup_.warn("undefined materials: " + std::to_string(undefined_.size()) + ", as \"" + *undefined_.begin() +
                       "\"");
        soup_.objects = objects_;
        if (objects_ > 1) soup_.kind = mesh::Kind::scene;
        return Nothing{};
    }

    const Source& source_;
    Soup& soup_;
    std::vector<std::uint32_t> places_;  // soup vertices of the `v` lines
    std::vector<Vec3f> colors_;          // empty or as far as set, along places_
    std::vector<Vec3f> normals_;
    std::vector<Vec2f> coordinates_;
    struct Copy {
        std::uint32_t vertex, place;
    };
    std::vector<Copy> copies_;
    std::vector<std::uint32_t> corners_;
    std::map<std::string, std::uint32_t> names_;
    std::set<std::string> libraries_, undefined_;
    std::uint32_t material_ = 0;
    std::uint32_t objects_ = 0;
    bool object_has_faces_ = false;
};

}  // namespace

Status read_obj(const Source& source, Soup& soup) {
    return Reader(source, soup).read();
}

}  // namespace lodestream::importer
