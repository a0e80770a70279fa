// Ridged multifractal (Musgrave, in "Texturing & Modeling", ch. 16) over rolling hills, sampled on a square grid.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <random>
#include <tuple>
#include <utility>
#include <vector>

#include "server/samples/count_limits.h"
#include "server/samples/samples.h"

namespace lodestream::samples {
namespace {

constexpr double max_height_m = 1'500.0;
constexpr double mountain_height_m = 2'800.0;
constexpr double valley_height_m = 250.0;     // relief of the hills that the ridges stand on
constexpr double largest_valley_m = 9'000.0;  // wavelengths
constexpr double largest_ridge_m = 3'500.0;
constexpr int valley_octaves = 3;
constexpr int ridge_octaves = 8;  // down to 27 m, the finest that a 10 m grid still shows
constexpr std::size_t table_size = 256;

// Perlin's gradient noise (2002) in the plane, about -1 … 1.
class Noise {
  public:
    explicit Noise(std::uint64_t seed) {
        std::mt19937_64 random(seed);
        std::array<std::uint8_t, table_size> order{};
        std::iota(order.begin(), order.end(), std::uint8_t{0});
        for (std::size_t i = table_size - 1; i > 0; --i) std::swap(order[i], order[random() % (i + 1)]);
        for (std::size_t i = 0; i < 2 * table_size; ++i) permutation_[i] = order[i % table_size];
        for (std::size_t i = 0; i < table_size; ++i) {
            const double angle = 2 * pi * static_cast<double>(i) / static_cast<double>(table_size);
            gradients_[i] = {std::cos(angle), std::sin(angle)};
        }
    }

    double operator()(double x, double z) const {
        const double cell_x = std::floor(x), cell_z = std::floor(z);
        const auto i = static_cast<std::size_t>(static_cast<std::int64_t>(cell_x)) % table_size;
        const auto j = static_cast<std::size_t>(static_cast<std::int64_t>(cell_z)) % table_size;
        const double u = x - cell_x, v = z - cell_z, fade_u = fade(u), fade_v = fade(v);
        const std::size_t left = permutation_[i], right = permutation_[i + 1];
        const double near = std::lerp(slope(left + j, u, v), slope(right + j, u - 1, v), fade_u);
        const double far = std::lerp(slope(left + j + 1, u, v - 1), slope(right + j + 1, u - 1, v - 1), fade_u);
        return std::lerp(near, far, fade_v) * 1.5;
    }

  private:
    static double fade(double t) { return t * t * t * (t * (t * 6 - 15) + 10); }
    double slope(std::size_t index, double u, double v) const {
        const auto& g = gradients_[permutation_[index]];
        return g[0] * u + g[1] * v;
    }

    std::array<std::uint8_t, 2 * table_size> permutation_{};
    std::array<std::array<double, 2>, table_size> gradients_{};
};

// Octaves are turned against each other, so that their lattices do not line up.
std::pair<double, double> turned(double x, double z) {
    return {0.8 * x - 0.6 * z + 17.3, 0.6 * x + 0.8 * z + 5.9};
}

double valleys(const Noise& noise, double x_m, double z_m) {
    double sum = 0, amplitude = 0.5, x = x_m / largest_valley_m, z = z_m / largest_valley_m;
    for (int octave = 0; octave < valley_octaves; ++octave) {
        sum += amplitude * noise(x, z);
        amplitude *= 0.5;
        std::tie(x, z) = turned(2 * x, 2 * z);
    }
    return std::clamp(0.5 + 0.5 * sum, 0.0, 1.0);
}

double ridges(const Noise& noise, double x_m, double z_m) {
    double sum = 0, total = 0, amplitude = 1, weight = 1, x = x_m / largest_ridge_m, z = z_m / largest_ridge_m;
    for (int octave = 0; octave < ridge_octaves; ++octave) {
        const double crest = std::max(0.0, 1 - std::abs(noise(x, z)));
        const double signal = crest * crest * weight;
        sum += amplitude * signal;
        total += amplitude;
        weight = std::clamp(1.6 * signal, 0.0, 1.0);  // valleys stay smooth: rough only where it is high already
        amplitude *= 0.47;
        std::tie(x, z) = turned(2 * x, 2 * z);
    }
    return sum / total;
}

double height_m(const Noise& noise, double x_m, double z_m) {
    const double hills = valleys(noise, x_m, z_m);
    const double mountains = hills * hills * ridges(noise, x_m, z_m);
    const double height = valley_height_m * hills + mountain_height_m * mountains;
    return height /
           std::pow(1 + std::pow(height / max_height_m, 4.0), 0.25);  // peaks lean towards the limit, none is cut flat
}

// `width` vertices a row, the last row perhaps shorter.
struct Grid {
    std::uint32_t width = 0, count = 0;
    std::uint32_t rows() const { return (count + width - 1) / width; }
    std::uint32_t length(std::uint32_t row) const { return std::min(width, count - row * width); }
};

Grid square_grid(std::uint64_t vertices) {
    auto width = static_cast<std::uint32_t>(std::sqrt(static_cast<double>(vertices)));
    while (std::uint64_t{width} * width < vertices) ++width;
    return {width, static_cast<std::uint32_t>(vertices)};
}

std::vector<Vec3f> heights(const Grid& grid, const Noise& noise) {
    std::vector<Vec3f> positions;
    positions.reserve(grid.count);
    const double middle_x = 0.5 * (grid.width - 1), middle_z = 0.5 * (grid.rows() - 1);
    for (std::uint32_t row = 0; row < grid.rows(); ++row)
        for (std::uint32_t column = 0; column < grid.length(row); ++column) {
            const double x = (column - middle_x) * terrain_spacing_m, z = (row - middle_z) * terrain_spacing_m;
            positions.emplace_back(Vec3d{x, height_m(noise, x, z), z});
        }
    return positions;
}

// Central differences, one-sided at the border.
std::vector<Vec3f> grid_normals(const Grid& grid, const std::vector<Vec3f>& positions) {
    std::vector<Vec3f> normals;
    normals.reserve(grid.count);
    const auto slope = [&](std::uint32_t i, bool lower, bool upper, std::uint32_t stride) {
        const std::uint32_t a = lower ? i - stride : i, b = upper ? i + stride : i;
        const double steps = (lower ? 1 : 0) + (upper ? 1 : 0);
        return steps > 0 ? (static_cast<double>(positions[b].y) - positions[a].y) / (steps * terrain_spacing_m) : 0.0;
    };
    for (std::uint32_t row = 0; row < grid.rows(); ++row)
        for (std::uint32_t column = 0; column < grid.length(row); ++column) {
            const std::uint32_t i = row * grid.width + column;
            const double dx = slope(i, column > 0, column + 1 < grid.length(row), 1);
            const double dz = slope(i, row > 0, i + grid.width < grid.count, grid.width);
            normals.emplace_back(normalize(Vec3d{-dx, 1, -dz}));
        }
    return normals;
}

Rgba8 ground_color(double height, double upright) {
    struct Band {
        double below_m;
        Vec3d color;
    };
    constexpr double snow_m = 1'050.0;
    static const std::array<Band, 4> bands{
        {{90, {0.16, 0.27, 0.06}}, {380, {0.09, 0.20, 0.05}}, {700, {0.17, 0.20, 0.08}}, {snow_m, {0.25, 0.22, 0.18}}}};
    const Vec3d rock{0.20, 0.18, 0.16}, snow{0.85, 0.87, 0.90};
    Vec3d color = snow;
    for (auto band = bands.rbegin(); band != bands.rend(); ++band) {
        const double above = std::clamp((height - band->below_m) / 120.0 + 0.5, 0.0, 1.0);
        color = band->color * (1 - above) + color * above;
    }
    const double steep = std::clamp((0.82 - upright) / 0.15, 0.0, 1.0);
    color = color * (1 - steep) + rock * steep;
    return Rgba8(Vec4d(color * 255.0 + 0.5, 255.0));
}

std::vector<Rgba8> ground_colors(const mesh::Mesh& mesh) {
    std::vector<Rgba8> colors;
    colors.reserve(mesh.positions.size());
    for (std::size_t i = 0; i < mesh.positions.size(); ++i)
        colors.push_back(ground_color(mesh.positions[i].y, mesh.normals[i].y));
    return colors;
}

// Quads along the diagonal that bends less; where the last row ends early, one triangle slopes back to the row before.
std::vector<mesh::Triangle> grid_triangles(const Grid& grid, const std::vector<Vec3f>& positions) {
    std::vector<mesh::Triangle> triangles;
    triangles.reserve(2 * std::size_t{grid.count});
    for (std::uint32_t row = 0; row + 1 < grid.rows(); ++row) {
        const std::uint32_t length = grid.length(row + 1);
        for (std::uint32_t column = 0; column + 1 < grid.width && column < length; ++column) {
            const std::uint32_t a = row * grid.width + column, b = a + 1, c = a + grid.width, d = c + 1;
            if (column + 1 == length) {
                triangles.push_back({a, c, b});
            } else if (std::abs(positions[a].y - positions[d].y) < std::abs(positions[b].y - positions[c].y)) {
                triangles.push_back({a, c, d});
                triangles.push_back({a, d, b});
            } else {
                triangles.push_back({a, c, b});
                triangles.push_back({b, c, d});
            }
        }
    }
    return triangles;
}

}  // namespace

Result<mesh::Model> terrain(std::uint64_t vertices, std::uint64_t seed) {
    if (auto error = outside("terrain vertices", vertices, min_terrain_vertices, max_terrain_vertices)) return *error;
    const Grid grid = square_grid(vertices);

    mesh::Model model;
    model.kind = mesh::Kind::terrain;
    model.mesh.positions = heights(grid, Noise(seed));
    model.mesh.normals = grid_normals(grid, model.mesh.positions);
    model.mesh.colors = ground_colors(model.mesh);
    model.mesh.triangles = grid_triangles(grid, model.mesh.positions);
    mesh::Material ground;
    ground.name = "ground";
    ground.roughness = 0.95f;
    model.materials = {ground};
    return model;
}

}  // namespace lodestream::samples
