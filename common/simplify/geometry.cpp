#include "common/simplify/geometry.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/base/z_order.h"
#include "common/mesh/operations.h"
#include "common/simplify/sheet_mesh.h"

namespace lodestream::simplify {

namespace {

// Areas of the largest triangles must stay well inside single precision.
constexpr int max_extent_exponent = 54;

constexpr unsigned code_bits = 30;

// Place along a Morton curve of a point of the unit cube, to a thousandth of it.
std::uint32_t morton_code(const Vec3d& p) {
    constexpr double cells = (1 << code_bits / 3) - 1;
    const auto cell = [](double x) { return static_cast<std::uint64_t>(std::clamp(x, 0.0, 1.0) * cells); };
    return static_cast<std::uint32_t>(z_order(cell(p.x), cell(p.y), cell(p.z)));
}

struct Place {
    std::uint32_t code;
    std::uint32_t triangle;
};

// Sorts by code; places of one code stay in their order. `other`: room to sort in.
void sort_by_code(std::vector<Place>& places, std::vector<Place>& other) {
    constexpr unsigned digit_bits = 10;
    constexpr std::size_t digits = std::size_t{1} << digit_bits;
    other.resize(places.size());
    for (unsigned shift = 0; shift < code_bits; shift += digit_bits) {
        const auto digit = [&](const Place& p) { return static_cast<std::size_t>(p.code >> shift) & (digits - 1); };
        std::vector<std::size_t> begin(digits + 1, 0);
        for (const Place& p : places) ++begin[digit(p) + 1];
        if (std::find(begin.begin(), begin.end(), places.size()) != begin.end()) continue;  // all of one digit
        std::partial_sum(begin.begin(), begin.end(), begin.begin());
        for (const Place& p : places) other[begin[digit(p)]++] = p;
        places.swap(other);
    }
}

void order_along_curve(const mesh::Mesh& mesh, const Box& box, std::vector<Place>& places, std::vector<Place>& other) {
    const Vec3d extent = box.extent();
    const double size = std::max({extent.x, extent.y, extent.z});
    const double to_unit = size > 0 ? 1.0 / size : 0.0;
    places.resize(mesh.triangles.size());
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const mesh::Triangle& v = mesh.triangles[t];
        Vec3d sum{0.0};
        for (const std::uint32_t corner : v) sum += Vec3d(mesh.positions[corner]) - box.min;
        places[t] = {morton_code(sum * (to_unit / 3.0)), t};
    }
    sort_by_code(places, other);
}

// The mean exponent of the triangles' sides: one far vertex does not move it.
int typical_exponent(const mesh::Mesh& mesh, const Box& box) {
    double sum = 0;
    std::size_t count = 0;
    for (const mesh::Triangle& t : mesh.triangles) {
        const double side = distance(Vec3d(mesh.positions[t[0]]), Vec3d(mesh.positions[t[1]]));
        if (!(side > 0)) continue;
        sum += std::ilogb(side);
        ++count;
    }
    const int typical = count > 0 ? static_cast<int>(std::floor(sum / static_cast<double>(count))) : 0;
    const double diagonal = box.diagonal();
    const int extent = diagonal > 0 ? std::ilogb(diagonal) + 1 : 0;
    return std::max(typical, extent - max_extent_exponent);
}

// Beside coordinates that are 2^70 times larger, small ones round to one spot; they are one position then.
std::vector<Vec3f> scaled_positions(const mesh::Mesh& mesh, int exponent) {
    const double scale = std::ldexp(1.0, -exponent);
    std::vector<Vec3f> scaled;
    scaled.reserve(mesh.positions.size());
    for (const Vec3f& p : mesh.positions) scaled.emplace_back(Vec3d(p) * scale);
    return scaled;
}

}  // namespace

Geometry weld(const mesh::Mesh& mesh, const Executor& executor) {
    Geometry g;
    const Box box = mesh::bounds(mesh);
    g.exponent = typical_exponent(mesh, box);
    const std::vector<Vec3f> scaled = scaled_positions(mesh, g.exponent);
    std::vector<std::uint32_t> first;
    std::vector<Place> order, other;
    for (std::vector<Place>* places : {&order, &other}) places->reserve(mesh.triangles.size());
    run(executor, 2, [&](std::size_t task) {
        if (task == 0)
            first = mesh::weld_positions(scaled);
        else
            order_along_curve(mesh, box, order, other);
    });
    other = {};
    std::vector<std::uint32_t> number(first.size(), none);
    const auto number_of = [&](std::uint32_t vertex) {
        std::uint32_t& position = number[vertex];
        if (position == none) {
            position = static_cast<std::uint32_t>(g.points.size());
            g.points.push_back(scaled[vertex]);
        }
        return position;
    };
    g.points.reserve(scaled.size());
    g.triangle_of.reserve(mesh.triangles.size());
    g.faces.reserve(mesh.triangles.size());
    for (const Place& place : order) {
        mesh::Triangle corners = mesh.triangles[place.triangle];
        for (std::uint32_t& c : corners) c = first[c];
        if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) continue;
        for (std::uint32_t& c : corners) c = number_of(c);
        g.triangle_of.push_back(place.triangle);
        g.faces.push_back(corners);
    }
    g.position_of.resize(first.size());
    for (std::size_t v = 0; v < first.size(); ++v) g.position_of[v] = number_of(first[v]);
    return g;
}

}  // namespace lodestream::simplify
