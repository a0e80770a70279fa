#include "common/simplify/preview.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>
#include <queue>
#include <utility>

#include "common/mesh/operations.h"
#include "common/metric/triangle_tree.h"

namespace lodestream::simplify {

namespace {

constexpr std::uint32_t none = 0xffffffff;
constexpr std::uint64_t cells_per_triangle = 4;  // a closed surface needs half a cell a triangle, scattered pieces more
constexpr double flatness = 1e-3;                // how much a vertex keeps to the mean where planes leave it free
constexpr std::size_t source_samples = 20'000;   // from the source to a level
constexpr std::size_t level_samples = 1'000;     // from a level to the source, at least; one a triangle
constexpr std::size_t looked_at = 1'024;         // of a cell's triangles, by one sample

// ---- Cells: a binary tree over the vertices, split widest first ----

struct Cell {
    std::uint32_t first, last;  // of the points
    Vec3f min{0.0f}, max{0.0f};
    std::uint32_t parent = none;
    std::uint32_t split_at = none;  // the step that halved it; none: a leaf
};

struct Cells {
    std::vector<Cell> all;
    std::vector<std::uint32_t> leaf_of;  // of each vertex
};

struct Point {
    Vec3f position;
    std::uint32_t vertex;
};

Vec3d extent_of(const Cell& cell) {
    return Vec3d(cell.max) - Vec3d(cell.min);
}

void find_box(Cell& cell, const std::vector<Point>& points) {
    cell.min = cell.max = points[cell.first].position;
    for (std::uint32_t i = cell.first; i < cell.last; ++i) {
        cell.min = min(cell.min, points[i].position);
        cell.max = max(cell.max, points[i].position);
    }
}

// Halves the cell at the middle of its longest side; both halves hold points because the box is tight.
void split(std::vector<Cell>& cells, std::uint32_t which, std::uint32_t step, std::vector<Point>& points) {
    const Cell cell = cells[which];
    const Vec3d extent = extent_of(cell);
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    const double middle = 0.5 * (static_cast<double>(cell.min[axis]) + static_cast<double>(cell.max[axis]));
    const auto border = std::partition(points.begin() + cell.first, points.begin() + cell.last,
                                       [&](const Point& p) { return static_cast<double>(p.position[axis]) < middle; });
    const auto half = static_cast<std::uint32_t>(border - points.begin());
    cells[which].split_at = step;
    for (Cell child : {Cell{cell.first, half}, Cell{half, cell.last}}) {
        child.parent = which;
        find_box(child, points);
        cells.push_back(child);
    }
}

Cells make_cells(const mesh::Mesh& mesh, std::uint64_t max_cells) {
    std::vector<Point> points(mesh.positions.size());
    for (std::uint32_t v = 0; v < points.size(); ++v) points[v] = {mesh.positions[v], v};
    Cells cells;
    cells.all.push_back({0, static_cast<std::uint32_t>(points.size())});
    find_box(cells.all[0], points);

    std::priority_queue<std::pair<double, std::uint32_t>> widest;
    const auto queue = [&](std::uint32_t cell) {
        const double width = length(extent_of(cells.all[cell]));
        if (width > 0.0) widest.emplace(width, ~cell);
    };
    queue(0);
    for (std::uint32_t step = 0; !widest.empty() && step + 1 < max_cells; ++step) {
        const std::uint32_t cell = ~widest.top().second;
        widest.pop();
        split(cells.all, cell, step, points);
        queue(static_cast<std::uint32_t>(cells.all.size()) - 2);
        queue(static_cast<std::uint32_t>(cells.all.size()) - 1);
    }
    cells.leaf_of.resize(points.size());
    for (std::uint32_t c = 0; c < cells.all.size(); ++c)
        if (cells.all[c].split_at == none)
            for (std::uint32_t i = cells.all[c].first; i < cells.all[c].last; ++i) cells.leaf_of[points[i].vertex] = c;
    return cells;
}

// The step that parts two leaves. Children have higher numbers than their parents.
std::uint32_t parting_step(const std::vector<Cell>& cells, std::uint32_t a, std::uint32_t b) {
    while (a != b) (a > b ? a : b) = cells[std::max(a, b)].parent;
    return cells[a].split_at;
}

// For each step the triangles whose corners lie in three cells from then on.
std::vector<std::uint64_t> count_appearing(const mesh::Mesh& mesh, const Cells& cells) {
    std::vector<std::uint64_t> appearing(cells.all.size() / 2 + 1, 0);
    for (const auto& [u, v, w] : mesh.triangles) {
        const std::uint32_t a = cells.leaf_of[u], b = cells.leaf_of[v], c = cells.leaf_of[w];
        if (a == b || b == c || c == a) continue;
        ++appearing[std::max(
            {parting_step(cells.all, a, b), parting_step(cells.all, b, c), parting_step(cells.all, c, a)})];
    }
    return appearing;
}

// The most steps after which at most `triangles` are there.
std::uint32_t steps_for(const std::vector<std::uint64_t>& appearing, std::uint64_t triangles) {
    std::uint32_t steps = 0;
    for (std::uint64_t there = 0; steps < appearing.size() && there + appearing[steps] <= triangles; ++steps)
        there += appearing[steps];
    return steps;
}

// Of each vertex the cell that it lies in after so many steps.
std::vector<std::uint32_t> cells_after(const Cells& cells, std::uint32_t steps) {
    std::vector<std::uint32_t> of_cell(cells.all.size());
    for (std::uint32_t c = 0; c < of_cell.size(); ++c) {
        const std::uint32_t parent = cells.all[c].parent;
        of_cell[c] = parent == none || cells.all[parent].split_at < steps ? c : of_cell[parent];
    }
    std::vector<std::uint32_t> of_vertex(cells.leaf_of.size());
    for (std::size_t v = 0; v < of_vertex.size(); ++v) of_vertex[v] = of_cell[cells.leaf_of[v]];
    return of_vertex;
}

// ---- Groups: what hangs together in a cell ----

class Groups {
  public:
    explicit Groups(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0u); }
    std::uint32_t find(std::uint32_t a) {
        while (parent_[a] != a) a = parent_[a] = parent_[parent_[a]];
        return a;
    }
    void unite(std::uint32_t a, std::uint32_t b) {
        a = find(a);
        b = find(b);
        parent_[std::max(a, b)] = std::min(a, b);
    }
    std::vector<std::uint32_t> roots() && {
        for (std::uint32_t a = 0; a < parent_.size(); ++a) parent_[a] = parent_[parent_[a]];
        return std::move(parent_);
    }

  private:
    std::vector<std::uint32_t> parent_;  // never above its child
};

struct Grouping {
    std::vector<std::uint32_t> wedge_of;     // of each vertex the first one it hangs together with by triangles
    std::vector<std::uint32_t> position_of;  // the same, joined over seams too
};

Grouping group(const mesh::Mesh& mesh, const std::vector<std::uint32_t>& welded,
               const std::vector<std::uint32_t>& cell_of) {
    Groups wedges(mesh.positions.size());
    for (const mesh::Triangle& t : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = t[k], b = t[(k + 1) % 3];
            if (cell_of[a] == cell_of[b]) wedges.unite(a, b);
        }
    Groups positions = wedges;
    for (std::uint32_t v = 0; v < welded.size(); ++v) positions.unite(v, welded[v]);
    return {std::move(wedges).roots(), std::move(positions).roots()};
}

bool is_split(const mesh::Triangle& t, const std::vector<std::uint32_t>& cell_of) {
    return cell_of[t[0]] != cell_of[t[1]] && cell_of[t[1]] != cell_of[t[2]] && cell_of[t[2]] != cell_of[t[0]];
}

// The triangles of the level, one for each three position groups.
std::vector<std::uint32_t> kept_triangles(const mesh::Mesh& mesh, const std::vector<std::uint32_t>& cell_of,
                                          const std::vector<std::uint32_t>& position_of) {
    using Key = std::array<std::uint32_t, 4>;  // groups, the lowest first; triangle
    std::vector<Key> keys;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        if (!is_split(mesh.triangles[t], cell_of)) continue;
        std::array<std::uint32_t, 3> groups{};
        for (std::size_t k = 0; k < 3; ++k) groups[k] = position_of[mesh.triangles[t][k]];
        std::rotate(groups.begin(), std::min_element(groups.begin(), groups.end()), groups.end());
        keys.push_back({groups[0], groups[1], groups[2], t});
    }
    std::sort(keys.begin(), keys.end());
    const auto same = [](const Key& a, const Key& b) { return a[0] == b[0] && a[1] == b[1] && a[2] == b[2]; };
    keys.erase(std::unique(keys.begin(), keys.end(), same), keys.end());
    std::vector<std::uint32_t> kept;
    for (const Key& key : keys) kept.push_back(key[3]);
    std::sort(kept.begin(), kept.end());
    return kept;
}

// Numbers the groups that the triangles use, in the order of use; `none` for the others.
std::vector<std::uint32_t> number_groups(const mesh::Mesh& mesh, const std::vector<std::uint32_t>& kept,
                                         const std::vector<std::uint32_t>& group_of, std::uint32_t& count) {
    std::vector<std::uint32_t> numbers(group_of.size(), none);
    count = 0;
    for (const std::uint32_t t : kept)
        for (const std::uint32_t v : mesh.triangles[t])
            if (std::uint32_t& number = numbers[group_of[v]]; number == none) number = count++;
    return numbers;
}

// The sum of the squared distances to planes, weighted by area, from an origin of its own.
struct PlaneSum {
    Mat3d matrix{0.0};
    Vec3d vector{0.0};
    Vec3d mean{0.0};
    double area = 0.0;

    void add(const Vec3d& normal, const Vec3d& corner, double weight) {
        matrix += weight * Mat3d(normal.x * normal, normal.y * normal, normal.z * normal);
        vector += weight * dot(normal, corner) * normal;
        mean += weight * corner;
        area += weight;
    }
    // The least, or the nearest to the mean of what is hardly more.
    Vec3d least() const {
        if (!(area > 0.0)) return Vec3d{0.0};
        const Mat3d m = matrix / area + Mat3d(flatness);
        const Vec3d v = (vector + flatness * mean) / area;
        const double whole = dot(m[0], cross(m[1], m[2]));
        return Vec3d{dot(v, cross(m[1], m[2])), dot(m[0], cross(v, m[2])), dot(m[0], cross(m[1], v))} / whole;
    }
};

std::vector<Vec3f> place_groups(const mesh::Mesh& mesh, const Cells& cells, const std::vector<std::uint32_t>& cell_of,
                                const std::vector<std::uint32_t>& position_of,
                                const std::vector<std::uint32_t>& numbers, std::uint32_t count) {
    std::vector<PlaneSum> sums(count);
    std::vector<std::uint32_t> cell_of_group(count);
    const auto origin = [&](std::uint32_t cell) {
        return 0.5 * (Vec3d(cells.all[cell].min) + Vec3d(cells.all[cell].max));
    };
    for (const mesh::Triangle& t : mesh.triangles) {
        const Vec3f &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
        const Vec3d normal = mesh::face_normal(a, b, c);
        const double area = mesh::face_area(a, b, c);
        for (const std::uint32_t v : t) {
            const std::uint32_t number = numbers[position_of[v]];
            if (number == none) continue;
            cell_of_group[number] = cell_of[v];
            sums[number].add(normal, Vec3d(mesh.positions[v]) - origin(cell_of[v]), area);
        }
    }
    std::vector<Vec3f> places;
    for (std::uint32_t g = 0; g < count; ++g) {
        const Cell& cell = cells.all[cell_of_group[g]];
        places.push_back(clamp(Vec3f(origin(cell_of_group[g]) + sums[g].least()), cell.min, cell.max));
    }
    return places;
}

// Of each wedge group the vertex nearest to where its position went.
std::vector<std::uint32_t> nearest_vertices(const mesh::Mesh& mesh, const std::vector<std::uint32_t>& wedge_numbers,
                                            const Grouping& grouping, const std::vector<std::uint32_t>& numbers,
                                            const std::vector<Vec3f>& places, std::uint32_t count) {
    std::vector<std::uint32_t> nearest(count, none);
    std::vector<double> distances(count, std::numeric_limits<double>::infinity());
    for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
        const std::uint32_t wedge = wedge_numbers[grouping.wedge_of[v]];
        if (wedge == none) continue;
        const double away = distance(Vec3d(mesh.positions[v]), Vec3d(places[numbers[grouping.position_of[v]]]));
        if (nearest[wedge] != none && !(away < distances[wedge])) continue;
        nearest[wedge] = v;
        distances[wedge] = away;
    }
    return nearest;
}

void add_vertex(mesh::Mesh& to, const mesh::Mesh& from, std::uint32_t v, const Vec3f& position) {
    to.positions.push_back(position);
    if (!from.normals.empty()) to.normals.push_back(from.normals[v]);
    if (!from.texture_coordinates.empty()) to.texture_coordinates.push_back(from.texture_coordinates[v]);
    if (!from.colors.empty()) to.colors.push_back(from.colors[v]);
}

void add_triangle(mesh::Mesh& to, const mesh::Mesh& from, std::uint32_t source, const mesh::Triangle& corners) {
    to.triangles.push_back(corners);
    if (!from.triangle_materials.empty()) to.triangle_materials.push_back(from.triangle_materials[source]);
}

// ---- Errors ----

// The k-th number of a fixed sequence, in [0, 1).
double even_number(std::uint64_t k, double irrational) {
    const double x = static_cast<double>(k + 1) * irrational;
    return x - std::floor(x);
}

Vec3d point_in(const metric::TriangleTree::Corners& t, std::uint64_t k) {
    double u = even_number(k, 0.7548776662466927), v = even_number(k, 0.5698402909980532);  // Roberts' R2 sequence
    if (u + v > 1.0) {
        u = 1.0 - u;
        v = 1.0 - v;
    }
    const Vec3d a(t[0]), b(t[1]), c(t[2]);
    return a + u * (b - a) + v * (c - a);
}

metric::TriangleTree::Corners corners_of(const mesh::Mesh& mesh, std::size_t t) {
    const auto& [a, b, c] = mesh.triangles[t];
    return {mesh.positions[a], mesh.positions[b], mesh.positions[c]};
}

struct Mean {
    double squares = 0.0, weight = 0.0, max = 0.0;
    void add(double distance, double w) {
        max = std::max(max, distance);
        squares += w * distance * distance;
        weight += w;
    }
    metric::SurfaceError error() const { return {weight > 0.0 ? std::sqrt(squares / weight) : max, max, 0.0}; }
};

// From points spread evenly over the source, and from its vertices for the maximum.
metric::SurfaceError error_to(const mesh::Mesh& mesh, const mesh::Mesh& level) {
    const metric::SurfaceIndex index(level);
    double whole = 0.0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto [a, b, c] = corners_of(mesh, t);
        whole += mesh::face_area(a, b, c);
    }
    const double strip = whole / static_cast<double>(source_samples);
    Mean mean;
    double covered = 0.0;
    std::uint64_t k = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto corners = corners_of(mesh, t);
        covered += mesh::face_area(corners[0], corners[1], corners[2]);
        for (; strip > 0.0 && (static_cast<double>(k) + 0.5) * strip < covered; ++k)
            mean.add(index.distance(point_in(corners, k)), 1.0);
    }
    const std::size_t stride = mesh.positions.size() / source_samples + 1;
    for (std::size_t v = 0; v < mesh.positions.size(); v += stride)
        mean.max = std::max(mean.max, index.distance(Vec3d(mesh.positions[v])));
    return mean.error();
}

// `vertex_of`: of each vertex of the source the one of the level that stands for it, if any does.
double normal_error_degrees(const mesh::Mesh& mesh, const mesh::Mesh& level,
                            const std::function<std::uint32_t(std::size_t)>& vertex_of) {
    metric::NormalError error;
    for (std::size_t v = 0; v < mesh.normals.size(); ++v)
        if (const std::uint32_t there = vertex_of(v); there != none)
            error.add(Vec3d(mesh.normals[v]), Vec3d(level.normals[there]));
    return error.degrees();
}

// The triangles of the source with a corner in each cell.
struct CellTriangles {
    std::vector<std::uint32_t> first;  // of each cell, into triangles; one more than cells
    std::vector<std::uint32_t> triangles;
};

CellTriangles triangles_of_cells(const mesh::Mesh& mesh, const std::vector<std::uint32_t>& cell_of, std::size_t cells) {
    CellTriangles result;
    result.first.assign(cells + 1, 0);
    const auto for_each = [&](const auto& visit) {
        for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
            const auto& [u, v, w] = mesh.triangles[t];
            const std::uint32_t a = cell_of[u], b = cell_of[v], c = cell_of[w];
            visit(a, t);
            if (b != a) visit(b, t);
            if (c != a && c != b) visit(c, t);
        }
    };
    for_each([&](std::uint32_t cell, std::uint32_t) { ++result.first[cell + 1]; });
    std::partial_sum(result.first.begin(), result.first.end(), result.first.begin());
    result.triangles.resize(result.first.back());
    std::vector<std::uint32_t> next(result.first.begin(), result.first.end() - 1);
    for_each([&](std::uint32_t cell, std::uint32_t t) { result.triangles[next[cell]++] = t; });
    return result;
}

// A level's triangle stands for one of the source that has a corner in each of three cells; the distance to the
// triangles around those corners is at least that to all of the source.
metric::SurfaceError error_from(const mesh::Mesh& level, const std::vector<std::uint32_t>& kept, const mesh::Mesh& mesh,
                                const std::vector<std::uint32_t>& cell_of, std::size_t cells) {
    const CellTriangles near = triangles_of_cells(mesh, cell_of, cells);
    const auto nearest = [&](const Vec3d& point, std::uint32_t source) {
        double squared = std::numeric_limits<double>::infinity();
        for (const std::uint32_t v : mesh.triangles[source]) {
            const std::uint32_t begin = near.first[cell_of[v]], end = near.first[cell_of[v] + 1];
            const auto stride = static_cast<std::uint32_t>((end - begin) / looked_at + 1);
            for (std::uint32_t i = begin; i < end; i += stride)
                squared = std::min(squared, metric::squared_distance(corners_of(mesh, near.triangles[i]), point));
        }
        return std::sqrt(squared);
    };
    const std::size_t samples = level_samples / level.triangles.size() + 1;
    Mean mean;
    for (std::size_t t = 0; t < level.triangles.size(); ++t) {
        const auto corners = corners_of(level, t);
        const double area = mesh::face_area(corners[0], corners[1], corners[2]);
        for (std::size_t k = 0; k < samples; ++k)
            mean.add(nearest(point_in(corners, samples * t + k), kept[t]), area / static_cast<double>(samples));
        mean.max = std::max(mean.max, nearest(Vec3d(corners[t % 3]), kept[t]));
    }
    return mean.error();
}

// ---- Levels ----

Preview clustered(const mesh::Mesh& mesh, const std::vector<std::uint32_t>& welded, const Cells& cells,
                  std::uint32_t steps) {
    const std::vector<std::uint32_t> cell_of = cells_after(cells, steps);
    const Grouping grouping = group(mesh, welded, cell_of);
    const std::vector<std::uint32_t> kept = kept_triangles(mesh, cell_of, grouping.position_of);
    if (kept.empty()) return {};
    std::uint32_t positions = 0, wedges = 0;
    const auto numbers = number_groups(mesh, kept, grouping.position_of, positions);
    const auto wedge_numbers = number_groups(mesh, kept, grouping.wedge_of, wedges);
    const auto places = place_groups(mesh, cells, cell_of, grouping.position_of, numbers, positions);

    mesh::Mesh level;
    for (const std::uint32_t v : nearest_vertices(mesh, wedge_numbers, grouping, numbers, places, wedges))
        add_vertex(level, mesh, v, places[numbers[grouping.position_of[v]]]);
    for (const std::uint32_t t : kept) {
        mesh::Triangle corners{};
        for (std::size_t k = 0; k < 3; ++k) corners[k] = wedge_numbers[grouping.wedge_of[mesh.triangles[t][k]]];
        add_triangle(level, mesh, t, corners);
    }
    const metric::SurfaceError out = error_to(mesh, level),
                               back = error_from(level, kept, mesh, cell_of, cells.all.size());
    const auto wedge_number_of = [&](std::size_t v) { return wedge_numbers[grouping.wedge_of[v]]; };
    return {
        mesh::compact(level),
        {std::max(out.rms, back.rms), std::max(out.max, back.max), normal_error_degrees(mesh, level, wedge_number_of)}};
}

Preview largest_triangles(const mesh::Mesh& mesh, std::uint64_t count) {
    std::vector<std::pair<double, std::uint32_t>> by_size;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto [a, b, c] = corners_of(mesh, t);
        by_size.emplace_back(-mesh::face_area(a, b, c), t);
    }
    const auto end = by_size.begin() + static_cast<std::ptrdiff_t>(std::min<std::uint64_t>(count, by_size.size()));
    std::nth_element(by_size.begin(), end, by_size.end());
    std::sort(by_size.begin(), end, [](const auto& a, const auto& b) { return a.second < b.second; });
    mesh::Mesh level;
    for (auto it = by_size.begin(); it != end; ++it) {
        const auto first = static_cast<std::uint32_t>(level.positions.size());
        for (const std::uint32_t v : mesh.triangles[it->second]) add_vertex(level, mesh, v, mesh.positions[v]);
        add_triangle(level, mesh, it->second, {first, first + 1, first + 2});
    }
    level = mesh::compact(level);
    return {level, level.triangles.size() == mesh.triangles.size() ? metric::SurfaceError{} : error_to(mesh, level)};
}

}  // namespace

std::vector<Preview> make_previews(const mesh::Mesh& mesh, std::span<const std::uint64_t> max_triangles,
                                   const Executor& executor) {
    std::vector<Preview> previews(max_triangles.size());
    if (mesh.triangles.empty() || max_triangles.empty()) return previews;
    const std::uint64_t most = *std::max_element(max_triangles.begin(), max_triangles.end());
    const Cells cells = make_cells(mesh, std::min<std::uint64_t>(most, mesh.triangles.size()) * cells_per_triangle);
    const std::vector<std::uint64_t> appearing = count_appearing(mesh, cells);
    const std::vector<std::uint32_t> welded = mesh::weld_positions(mesh.positions);
    const auto make = [&](std::size_t i) {
        const std::uint64_t count = max_triangles[i];
        if (mesh.triangles.size() > count) previews[i] = clustered(mesh, welded, cells, steps_for(appearing, count));
        if (previews[i].mesh.triangles.empty()) previews[i] = largest_triangles(mesh, count);
    };
    if (executor)
        executor(previews.size(), make);
    else
        for (std::size_t i = 0; i < previews.size(); ++i) make(i);
    return previews;
}

}  // namespace lodestream::simplify
