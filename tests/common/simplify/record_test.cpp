#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <ostream>
#include <string>
#include <thread>

#include "common/metric/surface_distance.h"
#include "common/simplify/history.h"
#include "tests/common/simplify/shapes.h"

namespace lodestream::simplify {
namespace {

using mesh::Mesh;
using testing::append;
using testing::area;
using testing::book;
using testing::flat_grid;
using testing::grid;
using testing::sphere;
using testing::tetrahedron;
using testing::textured_tube;

History record(const Mesh& m) {
    Result<History> history = record_history(m);
    EXPECT_TRUE(history.ok());
    return std::move(history).value();
}

Mesh level_of(const Mesh& m, std::uint64_t triangles) {
    return cut(record(m), triangles);
}

Mesh bumpy(std::uint32_t n) {
    return grid(n, [](double x, double z) { return std::sin(0.7 * x) * std::cos(0.5 * z); });
}

Mesh two_spheres() {
    Mesh m = sphere(8);
    append(m, sphere(6), {3, 0, 0});
    return m;
}

Mesh doubled_faces() {
    Mesh m = sphere(6);
    m.triangles.insert(m.triangles.end(), m.triangles.begin(), m.triangles.begin() + 30);
    return m;
}

Mesh double_sided() {
    Mesh m = flat_grid(5);
    for (std::size_t t = 0, n = m.triangles.size(); t < n; ++t)
        m.triangles.push_back({m.triangles[t][0], m.triangles[t][2], m.triangles[t][1]});
    return m;
}

Mesh shuffled_orientation() {
    Mesh m = sphere(8);
    for (std::size_t t = 0; t < m.triangles.size(); t += 3) std::swap(m.triangles[t][1], m.triangles[t][2]);
    return m;
}

Mesh two_fans_at_a_point() {
    Mesh m = tetrahedron();
    append(m, tetrahedron(), {0, 0, 0}, -1.0f);
    return mesh::compact(m);
}

Mesh moebius() {
    Mesh m;
    for (int k = 0; k < 16; ++k)
        for (const double w : {-0.3, 0.3}) {
            const double u = 2 * pi * k / 16, r = 1 + w * std::cos(u / 2);
            m.positions.emplace_back(Vec3d{r * std::cos(u), w * std::sin(u / 2), r * std::sin(u)});
        }
    for (std::uint32_t k = 0; k < 16; ++k) {
        const std::uint32_t a = 2 * k, b = a + 1, c = k == 15 ? 1 : a + 2, d = k == 15 ? 0 : a + 3;
        m.triangles.push_back({a, b, c});
        m.triangles.push_back({b, d, c});
    }
    return m;
}

Mesh many_crumbs() {
    Mesh m = sphere(10);
    for (int k = 0; k < 100; ++k) append(m, sphere(2), {3.0f + 0.1f * static_cast<float>(k), 0, 0}, 0.01f);
    return m;
}

Mesh crossing_spheres() {
    Mesh m = sphere(8);
    append(m, sphere(8), {0.5f, 0.25f, 0});
    return m;
}

// Sheets of one plane that lie on each other, of other triangles each.
Mesh coplanar_sheets() {
    Mesh m = flat_grid(6);
    append(m, flat_grid(5), {0.5f, 0, 0.5f});
    append(m, flat_grid(6), {0, 0, 0});
    return m;
}

// One corner lies a million sizes of the rest away.
Mesh one_far_vertex() {
    Mesh m = sphere(8);
    m.positions.back() = {1e6f, 2e6f, 0};
    return m;
}

Mesh stretched(float factor) {
    Mesh m = bumpy(8);
    for (Vec3f& p : m.positions) p.x *= factor;
    return m;
}

// Every triangle by its corners' places, turned so that the least comes first, in order.
std::vector<std::array<float, 9>> corners_of(const Mesh& m) {
    std::vector<std::array<float, 9>> all;
    for (const mesh::Triangle& t : m.triangles) {
        std::array<std::array<float, 9>, 3> turns{};
        for (std::size_t turn = 0; turn < 3; ++turn)
            for (std::size_t k = 0; k < 3; ++k)
                for (int axis = 0; axis < 3; ++axis)
                    turns[turn][3 * k + static_cast<std::size_t>(axis)] = m.positions[t[(turn + k) % 3]][axis] + 0.0f;
        all.push_back(*std::min_element(turns.begin(), turns.end()));
    }
    std::sort(all.begin(), all.end());
    return all;
}

struct Shape {
    std::string name;
    Mesh mesh;
};
std::ostream& operator<<(std::ostream& out, const Shape& shape) {
    return out << shape.name;
}

std::vector<Shape> shapes() {
    return {{"triangle", testing::single_triangle()},
            {"tetrahedron", tetrahedron()},
            {"sphere", sphere(10)},
            {"flat_grid", flat_grid(7)},
            {"bumpy_grid", bumpy(9)},
            {"torus", testing::torus(7)},
            {"soup", testing::soup(60)},
            {"book", book(7)},
            {"thick_book", book(70)},
            {"two_spheres", two_spheres()},
            {"tube", textured_tube(12, 6)},
            {"doubled_faces", doubled_faces()},
            {"double_sided", double_sided()},
            {"shuffled_orientation", shuffled_orientation()},
            {"two_fans_at_a_point", two_fans_at_a_point()},
            {"moebius", moebius()},
            {"many_crumbs", many_crumbs()},
            {"crossing_spheres", crossing_spheres()},
            {"coplanar_sheets", coplanar_sheets()},
            {"one_far_vertex", one_far_vertex()},
            {"needles", stretched(1e8f)},
            {"pressed", stretched(1e-8f)}};
}

class AnyShape : public ::testing::TestWithParam<Shape> {};
INSTANTIATE_TEST_SUITE_P(Shapes, AnyShape, ::testing::ValuesIn(shapes()),
                         [](const auto& shape) { return shape.param.name; });

TEST_P(AnyShape, IsCutToAnyBudgetOrOneBelow) {
    const Mesh& m = GetParam().mesh;
    const History history = record(m);
    for (std::uint64_t n = 1; n <= m.triangles.size() + 2; ++n) {
        const Mesh level = cut(history, n);
        EXPECT_LE(level.triangles.size(), n);
        EXPECT_GE(level.triangles.size() + 1, std::min<std::size_t>(n, m.triangles.size()));
        EXPECT_GE(level.triangles.size(), 1u);
    }
}

TEST_P(AnyShape, LevelsAreCompactAndStayNearTheSource) {
    const Mesh& m = GetParam().mesh;
    const History history = record(m);
    const Box box = mesh::bounds(m);
    for (std::uint64_t n = 1; n <= m.triangles.size(); n += 3) {
        const Mesh level = cut(history, n);
        std::vector<bool> used(level.positions.size(), false);
        for (const mesh::Triangle& t : level.triangles) {
            EXPECT_NE(level.positions[t[0]], level.positions[t[1]]);
            EXPECT_NE(level.positions[t[1]], level.positions[t[2]]);
            EXPECT_NE(level.positions[t[2]], level.positions[t[0]]);
            for (const std::uint32_t v : t) {
                ASSERT_LT(v, level.positions.size());
                used[v] = true;
            }
        }
        EXPECT_EQ(std::count(used.begin(), used.end(), false), 0);
        const Box outer = mesh::bounds(level);
        EXPECT_LE(distance(outer.center(), box.center()), box.diagonal());
        EXPECT_LE(outer.diagonal(), 1.5 * box.diagonal());
    }
}

TEST_P(AnyShape, TheFinestLevelIsTheSource) {
    const Mesh& m = GetParam().mesh;
    const Mesh level = cut(record(m), m.triangles.size());
    EXPECT_EQ(corners_of(level), corners_of(m));
}

TEST_P(AnyShape, HasAValidHistory) {
    const Mesh& m = GetParam().mesh;
    const History history = record(m);
    const Status status = validate(view(history));
    EXPECT_TRUE(status.ok()) << (status.ok() ? "" : status.error().message);
}

void expect_equal(const History& a, const History& b) {
    EXPECT_EQ(a.steps, b.steps);
    EXPECT_EQ(a.positions, b.positions);
    EXPECT_EQ(a.normals, b.normals);
    EXPECT_EQ(a.texture_coordinates, b.texture_coordinates);
    EXPECT_EQ(a.changed_vertices, b.changed_vertices);
    EXPECT_EQ(a.moved_corners, b.moved_corners);
    EXPECT_EQ(a.moved_corner_ends, b.moved_corner_ends);
    EXPECT_EQ(a.triangles, b.triangles);
    EXPECT_EQ(a.triangle_materials, b.triangle_materials);
}

TEST_P(AnyShape, IsRecordedTheSameWayAgain) {
    expect_equal(record(GetParam().mesh), record(GetParam().mesh));
}

TEST_P(AnyShape, IsRecordedAlikeAtAnySize) {
    const Mesh& m = GetParam().mesh;
    const History plain = record(m);
    for (const float factor : {0x1p-40f, 0x1p66f}) {
        Mesh other = m;
        for (Vec3f& p : other.positions) p *= factor;
        History history = record(other);
        for (Vec3f& p : history.positions) p /= factor;
        expect_equal(history, plain);
    }
}

// Runs the last task first and two at a time, the second half on another thread.
void run_backwards(std::size_t count, const std::function<void(std::size_t)>& task) {
    std::thread other([&] {
        for (std::size_t k = count; k-- > count / 2;) task(k);
    });
    for (std::size_t k = count / 2; k-- > 0;) task(k);
    other.join();
}

TEST(Record, IsTheSameOnAnyNumberOfThreads) {
    const Mesh m = grid(240, [](double x, double z) { return 3 * std::sin(0.1 * x) * std::cos(0.13 * z); });
    RecordOptions options;
    options.executor = run_backwards;
    expect_equal(*record_history(m, options), record(m));
}

TEST(Record, LosesLittleAtTheBordersOfItsRegions) {
    const Mesh m = grid(240, [](double x, double z) { return 3 * std::sin(0.1 * x) * std::cos(0.13 * z); });
    const metric::SurfaceIndex index(m);
    const History history = record(m);
    const metric::SurfaceError at_2 = metric::measure(index, m, cut(history, m.triangles.size() / 50));
    EXPECT_LT(at_2.rms, 0.065);
    EXPECT_LT(at_2.max, 0.5);
}

TEST(Record, IsAlikeAnywhere) {
    const Mesh m = grid(12, [](std::uint32_t x, std::uint32_t z) { return (x * 7 + z * 3) % 5; });
    Mesh moved = m;
    for (Vec3f& p : moved.positions) p += Vec3f{4096, -512, 100};
    const History here = record(m), there = record(moved);
    EXPECT_EQ(here.triangles.size(), there.triangles.size());
    const metric::SurfaceIndex index(m);
    for (const std::uint64_t n : {200, 100, 40}) {
        Mesh level = cut(there, n);
        for (Vec3f& p : level.positions) p -= Vec3f{4096, -512, 100};
        const double rms = metric::measure(index, m, cut(here, n)).rms;
        EXPECT_NEAR(metric::measure(index, m, level).rms, rms, 0.02 * rms);
    }
}

TEST(Record, IsAlikeTurnedAnyWay) {
    const Mesh m = grid(24, [](double x, double z) { return 2 * std::sin(0.4 * x) * std::cos(0.3 * z); });
    const History upright = record(m);
    const metric::SurfaceIndex index(m);
    for (const double angle : {0.5, 1.2, 2.9}) {
        Mesh turned = m;
        for (Vec3f& p : turned.positions)
            p = Vec3f(Vec3d{std::cos(angle) * p.x - std::sin(angle) * p.y,
                            std::sin(angle) * p.x + std::cos(angle) * p.y, double{p.z}});
        const History history = record(turned);
        const metric::SurfaceIndex turned_index(turned);
        for (const std::uint64_t n : {600, 200, 60}) {
            const double rms = metric::measure(index, m, cut(upright, n)).rms;
            EXPECT_NEAR(metric::measure(turned_index, turned, cut(history, n)).rms, rms, 0.1 * rms)
                << angle << " " << n;
        }
    }
}

TEST(Record, ThousandsOfTinyPiecesReachAnyCount) {
    Mesh m;
    for (int k = 0; k < 4000; ++k) append(m, tetrahedron(), {0.1f * static_cast<float>(k), 0, 0}, 0.01f);
    const History history = record(m);
    for (const std::uint64_t n : {1, 2, 5, 100, 3999, 8001, 16000}) {
        EXPECT_LE(cut(history, n).triangles.size(), n);
        EXPECT_GE(cut(history, n).triangles.size() + 1, n);
    }
}

TEST(Record, TakesAnEmptyMesh) {
    const History history = record({});
    EXPECT_TRUE(history.steps.empty());
    EXPECT_TRUE(cut(history, 10).triangles.empty());
}

TEST(Record, SurvivesTrianglesWithoutExtentAndUnusedVertices) {
    Mesh m = flat_grid(3);
    m.positions.push_back({9, 9, 9});
    m.triangles.push_back({0, 0, 1});
    m.triangles.push_back({2, 2, 2});
    const History history = record(m);
    EXPECT_TRUE(validate(view(history)).ok());
    EXPECT_EQ(cut(history, 18).triangles.size(), 18u);
}

TEST(Record, SurvivesExtentsAtTheEdgeOfFloat) {
    for (const float size : {1e-38f, 1e-30f, 1e30f, 3e38f}) {
        Mesh m = sphere(8);
        for (Vec3f& p : m.positions) p *= size;
        EXPECT_EQ(level_of(m, 40).triangles.size(), 40u);
    }
    Mesh mixed = sphere(8);
    append(mixed, sphere(8), {0, 0, 0}, 1e-30f);
    append(mixed, sphere(8), {0, 0, 0}, 1e30f);
    EXPECT_EQ(level_of(mixed, 60).triangles.size(), 60u);
}

TEST(Record, LeavesOutWhatRoundsAwayBesideSomethingEnormous) {
    Mesh mixed = sphere(8);
    append(mixed, sphere(8), {0, 0, 0}, 1e-26f);
    append(mixed, sphere(8), {0, 0, 0}, 1e36f);
    const History history = record(mixed);
    EXPECT_LT(triangle_count(view(history)), mixed.triangles.size());
    EXPECT_GE(triangle_count(view(history)), 2 * sphere(8).triangles.size());
    for (const std::uint64_t budget : {1, 30, 100, 1000})
        EXPECT_EQ(cut(history, budget).triangles.size(), triangles_within(view(history), budget));
}

TEST(Record, SurvivesAHubOfVeryManyTriangles) {
    Mesh m;
    const std::uint32_t rim = 3000;
    m.positions = {{0, 1, 0}, {0, -1, 0}};
    for (std::uint32_t k = 0; k < rim; ++k)
        m.positions.emplace_back(Vec3d{std::cos(2 * pi * k / rim), 0, -std::sin(2 * pi * k / rim)});
    for (std::uint32_t k = 0; k < rim; ++k) {
        m.triangles.push_back({0, 2 + k, 2 + (k + 1) % rim});
        m.triangles.push_back({1, 2 + (k + 1) % rim, 2 + k});
    }
    EXPECT_EQ(level_of(m, 16).triangles.size(), 16u);
}

TEST(Record, KeepsTheCornersAndTheAreaOfAFlatSheet) {
    const Mesh m = flat_grid(16);
    const History history = record(m);
    const metric::SurfaceIndex index(m);
    for (const std::uint64_t n : {300, 100, 30, 8, 2}) {
        const Mesh level = cut(history, n);
        for (const Vec3f& corner : {Vec3f{0, 0, 0}, Vec3f{16, 0, 0}, Vec3f{0, 0, 16}, Vec3f{16, 0, 16}})
            EXPECT_THAT(level.positions, ::testing::Contains(corner)) << n;
        EXPECT_DOUBLE_EQ(area(level), 256.0) << n;
        EXPECT_LT(metric::measure(index, m, level).max, 1e-5) << n;
    }
}

TEST(Record, ErrorGrowsAsTrianglesFall) {
    for (const Mesh& m : {sphere(32), bumpy(30), testing::torus(24)}) {
        const History history = record(m);
        const metric::SurfaceIndex index(m);
        double before = 0;
        for (double n = static_cast<double>(m.triangles.size()); n >= 40; n *= 0.5) {
            const double rms = metric::measure(index, m, cut(history, static_cast<std::uint64_t>(n))).rms;
            EXPECT_GE(rms, 0.9 * before) << n;
            before = rms;
        }
        EXPECT_GT(before, 0);
    }
}

TEST(Record, KeepsASphereClosedAndRound) {
    const Mesh m = sphere(40);
    const Mesh level = level_of(m, 400);
    EXPECT_LT(metric::measure(metric::SurfaceIndex(m), m, level).rms, 0.012);
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides;
    for (const mesh::Triangle& t : level.triangles)
        for (std::size_t k = 0; k < 3; ++k) {
            ++sides[{t[k], t[(k + 1) % 3]}];
            --sides[{t[(k + 1) % 3], t[k]}];
        }
    for (const auto& [side, count] : sides) EXPECT_EQ(count, 0);
}

TEST(Record, KeepsATextureSeam) {
    const Mesh m = textured_tube(24, 24);
    const History history = record(m);
    for (const std::uint64_t n : {600, 200, 60, 24}) {
        const Mesh level = cut(history, n);
        double texture_area = 0;
        for (const mesh::Triangle& t : level.triangles) {
            const Vec2f a = level.texture_coordinates[t[0]], b = level.texture_coordinates[t[1]],
                        c = level.texture_coordinates[t[2]];
            EXPECT_LE(std::max({a.x, b.x, c.x}) - std::min({a.x, b.x, c.x}), 0.5f) << n;
            texture_area += 0.5 * ((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x));
        }
        EXPECT_NEAR(texture_area, 1.0, 1e-5) << n;
    }
}

TEST(Record, KeepsAMaterialBorder) {
    Mesh m = flat_grid(12);
    for (const mesh::Triangle& t : m.triangles) {
        const Vec3f center = (m.positions[t[0]] + m.positions[t[1]] + m.positions[t[2]]) / 3.0f;
        m.triangle_materials.push_back(center.x < 5 ? 0u : 1u);
    }
    m = mesh::compact(m);
    const History history = record(m);
    for (const std::uint64_t n : {100, 20, 6, 4}) {
        const Mesh level = cut(history, n);
        ASSERT_EQ(level.triangle_materials.size(), level.triangles.size());
        double first = 0;
        for (std::size_t t = 0; t < level.triangles.size(); ++t) {
            const mesh::Triangle& c = level.triangles[t];
            if (level.triangle_materials[t] == 0)
                first += mesh::face_area(level.positions[c[0]], level.positions[c[1]], level.positions[c[2]]);
        }
        EXPECT_DOUBLE_EQ(first, 60.0) << n;
        EXPECT_DOUBLE_EQ(area(level), 144.0) << n;
    }
}

TEST(Record, KeepsAColorBorderSharp) {
    Mesh red = flat_grid(6), both = red;
    append(both, red, {6, 0, 0});
    both.colors.assign(both.positions.size(), Rgba8{255, 0, 0, 255});
    std::fill(both.colors.begin() + 49, both.colors.end(), Rgba8{0, 0, 255, 255});
    const Mesh level = level_of(both, 4);
    for (const mesh::Triangle& t : level.triangles) {
        EXPECT_EQ(level.colors[t[0]], level.colors[t[1]]);
        EXPECT_EQ(level.colors[t[1]], level.colors[t[2]]);
    }
    EXPECT_DOUBLE_EQ(area(level), 72.0);
}

TEST(Record, GoesOnWhereEveryVertexIsASeamCorner) {
    Mesh m;  // each triangle has its own place in the texture
    const Mesh ball = sphere(8);
    for (const mesh::Triangle& t : ball.triangles) {
        const auto base = static_cast<std::uint32_t>(m.positions.size());
        for (const std::uint32_t v : t) {
            m.positions.push_back(ball.positions[v]);
            m.texture_coordinates.emplace_back(static_cast<float>(base), static_cast<float>(v));
        }
        m.triangles.push_back({base, base + 1, base + 2});
    }
    const Mesh level = level_of(m, 40);
    EXPECT_EQ(level.triangles.size(), 40u);
    EXPECT_GT(area(level), 0.7 * area(ball));
}

TEST(Record, IsNotHeldUpByNormals) {
    Mesh m = sphere(12);
    m = mesh::with_normals(m, 1.0);  // faceted: no two triangles share a vertex
    ASSERT_GT(m.positions.size(), 500u);
    const Mesh level = level_of(m, 40);
    EXPECT_EQ(level.triangles.size(), 40u);
    EXPECT_GT(area(level), 0.8 * area(m));
}

TEST(Record, SharedVerticesTakeTheNearestNormal) {
    Mesh m = grid(8, [](double x, double) { return std::abs(x - 4); });
    m = mesh::with_normals(m, 30);  // a sharp ridge: two vertices at each of its positions
    const Mesh level = level_of(m, 4);
    for (const mesh::Triangle& t : level.triangles) {
        const Vec3d n = mesh::face_normal(level.positions[t[0]], level.positions[t[1]], level.positions[t[2]]);
        for (const std::uint32_t v : t) EXPECT_GT(dot(n, Vec3d(level.normals[v])), 0.99);
    }
}

TEST(Record, KeepsWhatTouchesTogether) {
    const Mesh m = [] {  // two sheets through one line
        Mesh cross = flat_grid(8);
        append(cross, flat_grid(8), {0, 0, 0});
        for (std::size_t v = 81; v < 162; ++v) {
            const Vec3f p = cross.positions[v];
            cross.positions[v] = {4, p.x - 4, p.z};
        }
        return mesh::compact(cross);
    }();
    const Mesh level = level_of(m, 8);
    EXPECT_NEAR(area(level), area(m), 1e-6);
    EXPECT_LT(metric::measure(metric::SurfaceIndex(m), m, level).max, 1e-5);
}

TEST(Record, DropsCrumbsBeforeItRuinsWhatIsSeen) {
    const Mesh m = many_crumbs();
    const Mesh ball = sphere(10), level = level_of(m, 100);
    std::size_t of_the_ball = 0;
    for (const mesh::Triangle& t : level.triangles) of_the_ball += level.positions[t[0]].x < 1.5f;
    EXPECT_GE(of_the_ball, 90u);
}

TEST(Record, DropsTheSmallestTriangleFirst) {
    Mesh m;
    for (int k = 0; k < 5; ++k)
        append(m, testing::single_triangle(), {static_cast<float>(10 * k), 0, 0}, static_cast<float>(5 - k));
    const History history = record(m);
    for (std::uint64_t n = 1; n <= 5; ++n) {
        const Mesh level = cut(history, n);
        ASSERT_EQ(level.triangles.size(), n);
        for (const Vec3f& p : level.positions) EXPECT_LT(p.x, 10 * static_cast<float>(n) - 4);
    }
}

TEST(Record, ReportsProgressUpwards) {
    std::vector<double> shares;
    RecordOptions options;
    options.progress = [&](double share) {
        shares.push_back(share);
        return true;
    };
    ASSERT_TRUE(record_history(sphere(100), options).ok());
    ASSERT_GE(shares.size(), 2u);
    EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
    EXPECT_GE(shares.front(), 0.0);
    EXPECT_LE(shares.back(), 1.0);
}

TEST(Record, CanBeCancelled) {
    RecordOptions options;
    int calls = 0;
    options.progress = [&](double) { return ++calls < 2; };
    const Result<History> history = record_history(sphere(100), options);
    ASSERT_FALSE(history.ok());
    EXPECT_EQ(history.error().code, ErrorCode::unavailable);
    EXPECT_EQ(calls, 2);
}

}  // namespace
}  // namespace lodestream::simplify
