#include <cctype>
#include <cmath>
#include <limits>

#include "common/image/codec.h"
#include "server/importer/formats.h"
#include "server/importer/text_cursor.h"

namespace lodestream::importer {
namespace {

constexpr double metres_per_degree = 40'007'863.0 / 360;  // along a meridian
constexpr double hole = std::numeric_limits<double>::quiet_NaN();

struct HeightGrid {
    std::uint64_t columns = 0, rows = 0;
    double spacing_x = 1, spacing_z = 1;
    double west = 0, north = 0;   // of the first sample; north is -z
    std::vector<double> heights;  // rows from the north; NaN: a hole
};

Status check_size(std::uint64_t columns, std::uint64_t rows, const Limits& limits) {
    if (columns < 2 || rows < 2)
        return invalid_input("is a grid of " + std::to_string(columns) + " x " + std::to_string(rows) +
                             " heights, which makes no surface");
    const std::uint64_t most = std::numeric_limits<std::uint32_t>::max();
    if (columns > most || rows > most) return fail(ErrorCode::limit_exceeded, "is a grid too large to address");
    return admit(columns * rows, 2 * (columns - 1) * (rows - 1), limits);
}

// Two triangles a cell, split along the diagonal between the more equal heights; one where a corner is a hole.
void add_cell(const HeightGrid& grid, std::uint64_t column, std::uint64_t row, Soup& soup) {
    const auto nw = static_cast<std::uint32_t>(row * grid.columns + column);
    const auto sw = static_cast<std::uint32_t>(nw + grid.columns);
    const std::uint32_t ne = nw + 1, se = sw + 1;
    const auto height = [&](std::uint32_t v) { return grid.heights[v]; };
    const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        if (!std::isnan(height(a) + height(b) + height(c))) soup.add_triangle({a, b, c});
    };
    const double along_nw_se = std::abs(height(nw) - height(se)), along_ne_sw = std::abs(height(ne) - height(sw));
    if (along_nw_se <= along_ne_sw || std::isnan(along_ne_sw)) {
        add(nw, sw, se);
        add(nw, se, ne);
    } else {
        add(nw, sw, ne);
        add(ne, sw, se);
    }
}

Status add_grid(const HeightGrid& grid, Soup& soup) {
    soup.kind = mesh::Kind::terrain;
    soup.positions.reserve(grid.heights.size());
    std::uint64_t known = 0;
    for (std::uint64_t row = 0; row < grid.rows; ++row)
        for (std::uint64_t column = 0; column < grid.columns; ++column) {
            const double height = grid.heights[row * grid.columns + column];
            known += std::isnan(height) ? 0 : 1;
            soup.add_vertex({grid.west + grid.spacing_x * static_cast<double>(column), height,
                             grid.spacing_z * static_cast<double>(row) - grid.north});
        }
    for (std::uint64_t row = 0; row + 1 < grid.rows; ++row)
        for (std::uint64_t column = 0; column + 1 < grid.columns; ++column) add_cell(grid, column, row, soup);
    if (soup.triangles.empty()) return invalid_input("has " + std::to_string(known) + " heights but no cell of them");
    return Nothing{};
}

// The latitude that an SRTM tile's name states, as N46E011; 0 where it states none.
double latitude_of(const std::string& stem) {
    const auto digit = [&](std::size_t i) { return std::isdigit(static_cast<unsigned char>(stem[i])) != 0; };
    if (stem.size() < 3 || !digit(1) || !digit(2)) return 0;
    const double degrees = (stem[1] - '0') * 10 + (stem[2] - '0') + 0.5;
    const char side = static_cast<char>(std::toupper(static_cast<unsigned char>(stem[0])));
    return side == 'N' ? degrees : side == 'S' ? degrees - 1 : 0;
}

struct AscHeader {
    double columns = 0, rows = 0, x = 0, y = 0, dx = 0, dy = 0, no_data = -9999;
    bool x_is_center = false, y_is_center = false;
};

Result<AscHeader> read_asc_header(TextCursor& cursor) {
    AscHeader header;
    while (cursor.find_word()) {
        TextCursor ahead = cursor;
        const std::string key = lower_case(ahead.word());
        if (!std::isalpha(static_cast<unsigned char>(key[0])) || key == "nan") break;
        const double value = ahead.number();
        if (std::isnan(value) && key != "nodata_value")
            return invalid_input("states no number for " + key.substr(0, 32));
        if (key == "ncols")
            header.columns = value;
        else if (key == "nrows")
            header.rows = value;
        else if (key == "xllcorner" || key == "xllcenter")
            header.x = value, header.x_is_center = key == "xllcenter";
        else if (key == "yllcorner" || key == "yllcenter")
            header.y = value, header.y_is_center = key == "yllcenter";
        else if (key == "cellsize")
            header.dx = header.dy = value;
        else if (key == "dx")
            header.dx = value;
        else if (key == "dy")
            header.dy = value;
        else if (key == "nodata_value")
            header.no_data = value;
        else
            return invalid_input("has the unknown grid field \"" + key.substr(0, 32) + "\"");
        cursor = ahead;
        cursor.skip_line();
    }
    const auto whole = [](double v) { return v >= 0 && v <= 1e9 && v == std::floor(v); };
    if (!whole(header.columns) || !whole(header.rows)) return invalid_input("states no grid size");
    if (!(header.dx > 0) || !(header.dy > 0)) return invalid_input("states no cell size");
    return header;
}

}  // namespace

Status read_terrain_png(const Source& source, Soup& soup) {
    const Result<image::Header> header = image::read_header(source.bytes);
    if (!header) return invalid_input("is not a readable PNG");
    HeightGrid grid;
    grid.columns = header->width;
    grid.rows = header->height;
    if (const Status fits = check_size(grid.columns, grid.rows, source.limits); !fits) return fits;
    const Result<image::Grey> image = image::decode_grey16_png(source.bytes);
    if (!image) return image.error();
    grid.heights.reserve(image->levels.size());
    for (const std::uint16_t level : image->levels) grid.heights.push_back(level * png_metres_per_level);
    soup.warn("PNG states no scale: taken as 1 m between samples and 1 cm a grey level");
    return add_grid(grid, soup);
}

// One degree square of big-endian metres, -32768 where unknown.
Status read_terrain_hgt(const Source& source, Soup& soup) {
    const std::uint64_t samples = source.bytes.size() / 2;
    const auto side = static_cast<std::uint64_t>(std::llround(std::sqrt(static_cast<double>(samples))));
    if (source.bytes.size() != 2 * side * side)
        return invalid_input("has " + std::to_string(source.bytes.size()) + " bytes, which is no square of heights");
    if (const Status fits = check_size(side, side, source.limits); !fits) return fits;
    HeightGrid grid;
    grid.columns = grid.rows = side;
    grid.spacing_z = metres_per_degree / static_cast<double>(side - 1);
    grid.spacing_x = grid.spacing_z * std::cos(radians(latitude_of(source.stem)));
    if (latitude_of(source.stem) == 0) soup.warn("the name states no latitude: cells taken as square");
    grid.heights.reserve(samples);
    for (std::size_t i = 0; i < samples; ++i) {
        const auto high = std::to_integer<std::uint16_t>(source.bytes[2 * i]);
        const auto low = std::to_integer<std::uint16_t>(source.bytes[2 * i + 1]);
        const auto height = static_cast<std::int16_t>(high << 8 | low);
        grid.heights.push_back(height == std::numeric_limits<std::int16_t>::min() ? hole : height);
    }
    return add_grid(grid, soup);
}

Status read_terrain_asc(const Source& source, Soup& soup) {
    TextCursor cursor(as_text(source.bytes));
    const Result<AscHeader> header = read_asc_header(cursor);
    if (!header) return header.error();
    HeightGrid grid;
    grid.columns = static_cast<std::uint64_t>(header->columns);
    grid.rows = static_cast<std::uint64_t>(header->rows);
    if (const Status fits = check_size(grid.columns, grid.rows, source.limits); !fits) return fits;
    const std::uint64_t samples = grid.columns * grid.rows;
    if (samples > cursor.bytes_left()) return invalid_input("states more heights than its size allows");
    grid.spacing_x = header->dx;
    grid.spacing_z = header->dy;
    grid.west = header->x + (header->x_is_center ? 0 : header->dx / 2);
    grid.north = header->y + (header->y_is_center ? 0 : header->dy / 2) + header->dy * (header->rows - 1);
    grid.heights.reserve(samples);
    for (std::uint64_t i = 0; i < samples; ++i) {
        if (!cursor.find_word())
            return invalid_input("states " + std::to_string(samples) + " heights but holds " + std::to_string(i));
        const double height = cursor.number();
        grid.heights.push_back(height == header->no_data || !std::isfinite(height) ? hole : height);
    }
    return add_grid(grid, soup);
}

}  // namespace lodestream::importer
