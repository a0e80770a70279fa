#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>
#include <type_traits>

#include "server/importer/formats.h"
#include "server/importer/images.h"
#include "server/importer/text_cursor.h"

namespace lodestream::importer {
namespace {

enum class Type { i8, u8, i16, u16, i32, u32, f32, f64 };

std::optional<Type> type_of(std::string_view name) {
    if (name == "char" || name == "int8") return Type::i8;
    if (name == "uchar" || name == "uint8") return Type::u8;
    if (name == "short" || name == "int16") return Type::i16;
    if (name == "ushort" || name == "uint16") return Type::u16;
    if (name == "int" || name == "int32") return Type::i32;
    if (name == "uint" || name == "uint32") return Type::u32;
    if (name == "float" || name == "float32") return Type::f32;
    if (name == "double" || name == "float64") return Type::f64;
    return std::nullopt;
}

constexpr std::size_t type_bytes[] = {1, 1, 2, 2, 4, 4, 4, 8};

// What a property means to us; the first ones are slots of a row of scalars.
enum Role : int {
    px,
    py,
    pz,
    nx,
    ny,
    nz,
    tu,
    tv,
    red,
    green,
    blue,
    alpha,
    slots,
    corner_indices,
    corner_coordinates,
    strip_indices,
    unused
};

Role role_of(std::string_view name, bool list) {
    struct Known {
        std::string_view name;
        Role role;
    };
    static constexpr Known scalars[] = {
        {"x", px},
        {"y", py},
        {"z", pz},
        {"nx", nx},
        {"ny", ny},
        {"nz", nz},
        {"s", tu},
        {"t", tv},
        {"u", tu},
        {"v", tv},
        {"texture_u", tu},
        {"texture_v", tv},
        {"texture_s", tu},
        {"texture_t", tv},
        {"red", red},
        {"green", green},
        {"blue", blue},
        {"alpha", alpha},
        {"r", red},
        {"g", green},
        {"b", blue},
        {"a", alpha},
        {"diffuse_red", red},
        {"diffuse_green", green},
        {"diffuse_blue", blue},
        {"diffuse_alpha", alpha},
    };
    static constexpr Known lists[] = {
        {"vertex_indices", corner_indices},
        {"vertex_index", corner_indices},
        {"texcoord", corner_coordinates},
    };
    for (const Known& known : list ? std::span<const Known>(lists) : std::span<const Known>(scalars))
        if (known.name == name) return known.role;
    return unused;
}

struct Property {
    Role role = unused;
    Type type = Type::f32;
    std::optional<Type> count_type;  // lists
};

struct Element {
    std::string name;
    std::uint64_t count = 0;
    std::vector<Property> properties;

    bool has(Role role) const {
        return std::any_of(properties.begin(), properties.end(), [role](const Property& p) { return p.role == role; });
    }
};

enum class Encoding { ascii, little_endian, big_endian };

struct Header {
    Encoding encoding = Encoding::ascii;
    std::vector<Element> elements;
    std::string texture_file;
    std::size_t bytes = 0;
};

Result<Property> read_property(TextCursor& line, std::string_view element) {
    Property property;
    std::string_view word = line.word();
    const bool list = word == "list";
    if (list) {
        property.count_type = type_of(line.word());
        if (!property.count_type) return invalid_input("has a list whose count is of no known type");
        word = line.word();
    }
    const std::optional<Type> type = type_of(word);
    if (!type) return invalid_input("has a property of unknown type \"" + std::string(word.substr(0, 32)) + "\"");
    property.type = *type;
    property.role = role_of(line.word(), list);
    if (list && element == "tristrips" && property.role == corner_indices) property.role = strip_indices;
    return property;
}

// One header line; true at end_header.
Result<bool> read_header_line(TextCursor& line, Header& header) {
    const std::string_view keyword = line.word();
    if (keyword == "end_header") return true;
    if (keyword == "format") {
        const std::string_view encoding = line.word();
        if (encoding == "ascii")
            header.encoding = Encoding::ascii;
        else if (encoding == "binary_little_endian")
            header.encoding = Encoding::little_endian;
        else if (encoding == "binary_big_endian")
            header.encoding = Encoding::big_endian;
        else
            return invalid_input("is of unknown PLY format \"" + std::string(encoding.substr(0, 32)) + "\"");
    } else if (keyword == "element") {
        Element element;
        element.name = std::string(line.word());
        const double count = line.number();
        if (!(count >= 0 && count < 1e18))
            return invalid_input("states no count of element " + element.name.substr(0, 32));
        element.count = static_cast<std::uint64_t>(count);
        header.elements.push_back(std::move(element));
    } else if (keyword == "property") {
        if (header.elements.empty()) return invalid_input("has a property before any element");
        Element& element = header.elements.back();
        Result<Property> property = read_property(line, element.name);
        if (!property) return property.error();
        element.properties.push_back(*property);
    } else if (keyword == "comment" && line.word() == "TextureFile") {
        header.texture_file = std::string(line.rest_of_line());
    }
    return false;
}

Result<Header> read_header(std::string_view text) {
    Header header;
    TextCursor cursor(text);
    if (!cursor.find_word() || cursor.word() != "ply") return invalid_input("does not begin with \"ply\"");
    while (true) {
        cursor.skip_line();
        if (cursor.bytes_left() == 0) return invalid_input("has a header without end_header");
        TextCursor line = cursor;
        const Result<bool> ended = read_header_line(line, header);
        if (!ended) return ended.error();
        if (*ended) break;
    }
    cursor.skip_line();
    header.bytes = text.size() - cursor.bytes_left();
    return header;
}

// The two ways to the next scalar. `missing` is set once the data ends too early.
class TextValues {
  public:
    explicit TextValues(std::span<const std::byte> data) : cursor_(as_text(data)) {}
    std::uint64_t most_left() const { return cursor_.bytes_left() / 2 + 1; }  // a digit and a blank each
    double next(Type) {
        if (!cursor_.find_word()) {
            missing = true;
            return std::nan("");
        }
        return cursor_.number();
    }
    void skip(Type type, std::uint64_t count) {
        for (std::uint64_t i = 0; i < count && !missing; ++i) next(type);
    }
    bool missing = false;

  private:
    TextCursor cursor_;
};

template <bool Swapped>
class BinaryValues {
  public:
    explicit BinaryValues(std::span<const std::byte> data) : data_(data) {}
    std::uint64_t most_left() const { return data_.size(); }
    double next(Type type) {
        switch (type) {
            case Type::i8:
                return take<std::int8_t>();
            case Type::u8:
                return take<std::uint8_t>();
            case Type::i16:
                return take<std::int16_t>();
            case Type::u16:
                return take<std::uint16_t>();
            case Type::i32:
                return take<std::int32_t>();
            case Type::u32:
                return take<std::uint32_t>();
            case Type::f32:
                return static_cast<double>(take<float>());
            case Type::f64:
                return take<double>();
        }
        return 0;
    }
    void skip(Type type, std::uint64_t count) {
        const std::size_t size = type_bytes[static_cast<int>(type)];
        missing = missing || count > data_.size() / size;
        if (!missing) data_ = data_.subspan(count * size);
    }
    bool missing = false;

  private:
    template <class T>
    T take() {
        if (data_.size() < sizeof(T)) {
            missing = true;
            return T{};
        }
        std::byte bytes[sizeof(T)];
        std::memcpy(bytes, data_.data(), sizeof(T));
        if constexpr (Swapped) std::reverse(std::begin(bytes), std::end(bytes));
        data_ = data_.subspan(sizeof(T));
        return std::bit_cast<T>(bytes);
    }

    std::span<const std::byte> data_;
};

float color_scale(Type type) {
    switch (type) {
        case Type::u8:
            return 1.0f / 255;
        case Type::u16:
            return 1.0f / 65535;
        case Type::f32:
        case Type::f64:
            return 1.0f;
        default:
            return 1.0f / 255;
    }
}

struct Row {
    double slot[slots] = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1};
    float color_scale = 1;
    std::vector<double> indices;
    std::vector<double> coordinates;
    std::vector<double> strip;

    Rgba8 color() const {
        const auto part = [&](Role role) { return static_cast<float>(slot[role]) * color_scale; };
        return linear_from_srgb(Vec4f{part(red), part(green), part(blue), part(alpha)});
    }
};

template <class Values>
void read_list(Values& values, const Property& property, Row& row) {
    const double stated = values.next(*property.count_type);
    if (!(stated >= 0) || stated > static_cast<double>(values.most_left())) {
        values.missing = true;
        return;
    }
    const auto count = static_cast<std::uint64_t>(stated);
    std::vector<double>* to = property.role == corner_indices       ? &row.indices
                              : property.role == corner_coordinates ? &row.coordinates
                              : property.role == strip_indices      ? &row.strip
                                                                    : nullptr;
    if (!to) return values.skip(property.type, count);
    to->clear();
    for (std::uint64_t i = 0; i < count && !values.missing; ++i) to->push_back(values.next(property.type));
}

template <class Values>
void read_row(Values& values, const Element& element, Row& row) {
    for (const Property& property : element.properties) {
        if (property.count_type) {
            read_list(values, property, row);
        } else {
            const double value = values.next(property.type);
            if (property.role < slots) row.slot[property.role] = value;
        }
        if (values.missing) return;
    }
}

// Where colours have no alpha of their own they are opaque, whatever their type.
Row row_of(const Element& element) {
    Row row;
    for (const Property& property : element.properties)
        if (property.role == red) row.color_scale = color_scale(property.type);
    row.slot[alpha] = 1 / static_cast<double>(row.color_scale);
    return row;
}

class Reader {
  public:
    Reader(const Source& source, const Header& header, Soup& soup) : source_(source), header_(header), soup_(soup) {
        for (const Element& element : header.elements)
            if (element.name == "vertex") vertices_ += element.count;
    }

    template <class Values>
    Status read(Values values) {
        for (const Element& element : header_.elements) {
            if (element.properties.empty()) continue;
            if (element.count > values.most_left() / element.properties.size() + 1)
                return invalid_input("states " + std::to_string(element.count) + " of element " + element.name +
                                     ", more than its size allows");
            if (const Status fits = admit_element(element); !fits) return fits;
            if (const Status read = read_element(values, element); !read) return read;
        }
        return Nothing{};
    }

  private:
    Status admit_element(const Element& element) const {
        return admit(element.name == "vertex" ? element.count : 0, element.name == "face" ? element.count : 0,
                     source_.limits);
    }

    template <class Values>
    Status read_element(Values& values, const Element& element) {
        Row row = row_of(element);
        const bool is_vertex = element.name == "vertex" && element.has(px) && element.has(py) && element.has(pz);
        const bool has_normals = element.has(nx) && element.has(ny) && element.has(nz);
        const bool has_coordinates = element.has(tu) && element.has(tv);
        const bool has_colors = element.has(red) && element.has(green) && element.has(blue);
        for (std::uint64_t i = 0; i < element.count; ++i) {
            read_row(values, element, row);
            if (values.missing)
                return invalid_input("states " + std::to_string(element.count) + " of element " + element.name +
                                     " but holds " + std::to_string(i));
            if (is_vertex) {
                const std::uint32_t v = soup_.add_vertex({row.slot[px], row.slot[py], row.slot[pz]});
                if (has_normals) soup_.set_normal(v, Vec3f(Vec3d{row.slot[nx], row.slot[ny], row.slot[nz]}));
                if (has_coordinates) soup_.set_texture_coordinate(v, coordinate(row.slot[tu], row.slot[tv]));
                if (has_colors) soup_.set_color(v, row.color());
            } else {
                if (!row.indices.empty()) add_face(row, has_colors);
                if (!row.strip.empty()) add_strips(row.strip);
                row.indices.clear();
                row.strip.clear();
            }
            if (soup_.triangles.size() > source_.limits.triangles)
                return admit(0, soup_.triangles.size(), source_.limits);
        }
        return Nothing{};
    }

    // PLY's images begin at the lower left, glTF's at the upper left.
    static Vec2f coordinate(double u, double v) { return Vec2f(glm::dvec2{u, 1 - v}); }

    bool in_range(double index) const {
        return index >= 0 && index < static_cast<double>(soup_.positions.size()) &&
               index < static_cast<double>(vertices_);
    }

    void add_face(const Row& row, bool has_colors) {
        corners_.clear();
        for (const double index : row.indices) {
            if (!in_range(index)) {
                ++soup_.out_of_range_faces;
                return;
            }
            corners_.push_back(static_cast<std::uint32_t>(index));
        }
        const bool own_colors = has_colors && !vertices_have_colors();
        const bool own_coordinates = row.coordinates.size() == 2 * corners_.size();
        if (own_colors || own_coordinates)
            for (std::size_t i = 0; i < corners_.size(); ++i) {
                corners_[i] = soup_.copy_vertex(corners_[i]);
                if (own_colors) soup_.set_color(corners_[i], row.color());
                if (own_coordinates)
                    soup_.set_texture_coordinate(corners_[i],
                                                 coordinate(row.coordinates[2 * i], row.coordinates[2 * i + 1]));
            }
        soup_.add_polygon(corners_);
    }

    bool vertices_have_colors() const {
        return std::any_of(header_.elements.begin(), header_.elements.end(),
                           [](const Element& e) { return e.name == "vertex" && e.has(red); });
    }

    // Strips one after another, -1 between them.
    void add_strips(const std::vector<double>& strip) {
        for (std::size_t begin = 0, i = 0; i < strip.size(); ++i) {
            if (strip[i] < 0) {
                begin = i + 1;
            } else if (i >= begin + 2) {
                double a = strip[i - 2], b = strip[i - 1];
                if ((i - begin) % 2 == 1) std::swap(a, b);
                if (in_range(a) && in_range(b) && in_range(strip[i]))
                    soup_.add_triangle({static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b),
                                        static_cast<std::uint32_t>(strip[i])});
                else
                    ++soup_.out_of_range_faces;
            }
        }
    }

    const Source& source_;
    const Header& header_;
    Soup& soup_;
    std::uint64_t vertices_ = 0;
    std::vector<std::uint32_t> corners_;
};

}  // namespace

Status read_ply(const Source& source, Soup& soup) {
    const Result<Header> header = read_header(as_text(source.bytes));
    if (!header) return header.error();
    if (!header->texture_file.empty()) {
        const int image = add_image_file(header->texture_file, source.side_files, source.limits, soup);
        soup.materials.emplace_back().base_color_texture.image = image;
    }
    soup.may_be_cloud = true;
    Reader reader(source, *header, soup);
    const std::span<const std::byte> data = source.bytes.subspan(header->bytes);
    switch (header->encoding) {
        case Encoding::ascii:
            return reader.read(TextValues(data));
        case Encoding::little_endian:
            return reader.read(BinaryValues<false>(data));
        case Encoding::big_endian:
            return reader.read(BinaryValues<true>(data));
    }
    return Nothing{};
}

}  // namespace lodestream::importer
