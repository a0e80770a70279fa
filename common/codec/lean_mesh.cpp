#include "common/codec/lean_mesh.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <numeric>
#include <string>
#include <utility>

#include "common/codec/adaptive_coder.h"

namespace lodestream::codec {
namespace {

constexpr std::uint32_t none = 0xffffffffu;
// A triangle costs at least a symbol that is as sure as it can be: a thousandth of a bit.
constexpr std::uint64_t max_triangles_per_byte = 4096;
// Points at one position that a corner is compared with.
constexpr int max_compared_points = 64;
constexpr std::uint64_t max_attributes = 2;
constexpr std::int32_t opaque = 255;
// The first byte. Streams of before began with their count of triangles.
constexpr std::byte version{2};

GridPoint operator+(const GridPoint& a, const GridPoint& b) {
    return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

GridPoint operator-(const GridPoint& a, const GridPoint& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

std::int64_t dot(const GridPoint& a, const GridPoint& b) {
    return std::int64_t{a[0]} * b[0] + std::int64_t{a[1]} * b[1] + std::int64_t{a[2]} * b[2];
}

std::int32_t largest(const GridPoint& p) {
    return std::max({std::abs(p[0]), std::abs(p[1]), std::abs(p[2])});
}

int bits_of(std::int32_t value) {
    return std::bit_width(static_cast<std::uint32_t>(std::abs(value)));
}

Vec3d as_vector(const GridPoint& p) {
    return {p[0], p[1], p[2]};
}

// The nearest whole number, within twice what a coordinate may be. pre: not NaN
std::int32_t rounded(double value) {
    constexpr double limit = 2.0 * max_lean_coordinate;
    return static_cast<std::int32_t>(std::clamp(value, -limit, limit) + (limit + 0.5)) - 2 * max_lean_coordinate;
}

bool is_within(std::int64_t value) {
    return value >= -max_lean_coordinate && value <= max_lean_coordinate;
}

bool is_value(LeanAttribute::Kind kind, std::int32_t value) {
    return kind == LeanAttribute::Kind::color ? value >= 0 && value <= 255 : is_within(value);
}

// The angle of a border's corner, over which no triangle is known yet, as a context.
namespace angle {
// 0: above 120 degrees; 7: below about 28.
constexpr std::uint8_t least_urgent = 1, sharpest = 7;
constexpr std::uint8_t reflex = 8;
constexpr std::uint8_t unknown = 9;
constexpr std::size_t count = 9;  // that are known
}  // namespace angle

Vec3f between(const GridPoint& from, const GridPoint& to) {
    return {static_cast<float>(to[0] - from[0]), static_cast<float>(to[1] - from[1]),
            static_cast<float>(to[2] - from[2])};
}

// What a border's corner between edges e and f is, reflex where f turns to the other side of e than the known
// triangle's third corner, at the end of g, lies on.
inline std::uint8_t angle_between(const Vec3f& e, const Vec3f& f, const Vec3f& g) {
    const float length = dot(e, e), product = dot(e, f);
    const float turn = dot(g, e) * product - dot(g, f) * length;  // of the planes that e spans with g and with f
    const float square = product * std::abs(product), lengths = length * dot(f, f);
    // Squares of cosines, with their signs. All are compared, for a branch would seldom be foreseen; none is above 2.
    constexpr std::array limits{-0.25f, 0.0f, 0.0625f, 0.25f, 0.4125f, 0.6f, 0.78125f, 2.0f};
    std::int32_t sharpness = 0;
    for (const float limit : limits) sharpness += square > limit * lengths ? 1 : 0;
    const std::int32_t is_reflex = turn < 0.0f ? 1 : 0;
    return static_cast<std::uint8_t>(is_reflex * angle::reflex + (1 - is_reflex) * sharpness);
}

// What the encoder alone knows: the mesh, what of it has been told, and under which numbers.
class Source {
  public:
    explicit Source(const LeanMesh& mesh)
        : mesh_(mesh),
          is_told_(mesh.triangles.size(), 0),
          position_numbers_(mesh.positions.size(), none),
          point_numbers_(mesh.position_of_point.size(), none),
          first_(mesh.positions.size() + 1, 0) {
        for (std::uint32_t c = 0; c < corners(); ++c) ++first_[position(c) + 1];
        std::partial_sum(first_.begin(), first_.end(), first_.begin());
        edges_.resize(corners());
        std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
        for (std::uint32_t c = 0; c < corners(); ++c) edges_[next[position(c)]++] = {position(following(c)), c, 0};
        for (std::size_t p = 0; p < mesh.positions.size(); ++p)
            std::sort(edges_.begin() + first_[p], edges_.begin() + first_[p + 1], [](const Edge& a, const Edge& b) {
                return std::pair(a.to, a.corner) < std::pair(b.to, b.corner);
            });
    }

    static std::uint32_t following(std::uint32_t corner) { return corner % 3 == 2 ? corner - 2 : corner + 1; }

    // The first corner of a triangle that has not been told.
    std::uint32_t first_untold() {
        while (is_told_[next_]) ++next_;
        return 3 * next_;
    }
    // The corner across from the edge from one position to another, of a triangle that has not been told; none if there
    // is no such triangle.
    std::uint32_t across(std::uint32_t from_number, std::uint32_t to_number) {
        const std::uint32_t from = position_sources_[from_number], to = position_sources_[to_number];
        const auto end = edges_.begin() + first_[from + 1];
        const auto run = std::lower_bound(edges_.begin() + first_[from], end, to,
                                          [](const Edge& e, std::uint32_t value) { return e.to < value; });
        if (run == end || run->to != to) return none;
        // Those that have been told are passed once and for all.
        auto edge = run + run->told;
        while (edge != end && edge->to == to && is_told_[edge->corner / 3]) ++edge;
        run->told = static_cast<std::uint32_t>(edge - run);
        return edge != end && edge->to == to ? following(following(edge->corner)) : none;
    }
    void tell(std::uint32_t corner) { is_told_[corner / 3] = 1; }

    const GridPoint& place(std::uint32_t corner) const { return mesh_.positions[position(corner)]; }
    std::int32_t value(std::size_t attribute, std::uint32_t corner, std::size_t component) const {
        const LeanAttribute& from = mesh_.attributes[attribute];
        return from.values[point(corner) * from.components() + component];
    }
    std::uint32_t position_number(std::uint32_t corner) const { return position_numbers_[position(corner)]; }
    std::uint32_t point_number(std::uint32_t corner) const { return point_numbers_[point(corner)]; }
    void number_position(std::uint32_t corner, std::uint32_t number) {
        position_numbers_[position(corner)] = number;
        position_sources_.push_back(position(corner));
    }
    void number_point(std::uint32_t corner, std::uint32_t number) { point_numbers_[point(corner)] = number; }

    std::vector<std::uint32_t> told_corners;

  private:
    struct Edge {
        std::uint32_t to, corner, told;  // told: of the first edge of a run, how many of it
    };

    std::uint32_t corners() const { return static_cast<std::uint32_t>(3 * mesh_.triangles.size()); }
    std::uint32_t point(std::uint32_t corner) const { return mesh_.triangles[corner / 3][corner % 3]; }
    std::uint32_t position(std::uint32_t corner) const { return mesh_.position_of_point[point(corner)]; }

    const LeanMesh& mesh_;
    std::vector<std::uint8_t> is_told_;
    std::uint32_t next_ = 0;
    std::vector<std::uint32_t> position_numbers_, point_numbers_, position_sources_;
    std::vector<std::uint32_t> first_;
    std::vector<Edge> edges_;  // of each position those that leave it
};

// Thrown and caught in this file only.
struct Damaged {};
struct TooMany {};

// Positions, from what is known around them.
template <class Coder>
class PositionCoder {
  public:
    explicit PositionCoder(Coder& coder) : coder_(coder) {
        // Of levels of many models.
        for (int size = 0; size <= largest_size; ++size) {
            for (int shape = 0; shape < 4; ++shape) first_[index(size)][index(shape)] = NumberModel(size + shape - 3);
            for (int u = 0; u < 8; ++u) second_[index(size)][index(u)] = NumberModel(size - 2 + u / 4);
        }
        for (int bend = 0; bend <= largest_size; ++bend) heights_[index(bend)].fill(NumberModel(bend));
    }

    // A corner of the border at one end of the edge that a position is told over, where its neighbour along the border
    // is known.
    struct Side {
        std::uint8_t angle = angle::unknown;
        GridPoint neighbour{};
    };

    // `triangle`: the two ends of the edge and the corner across of it. `bend`: about how many bits its corners were
    // off the planes; is set to what the new one is.
    GridPoint code(const GridPoint& wanted, const std::array<GridPoint, 3>& triangle, const std::array<Side, 2>& sides,
                   int& bend) {
        const auto& [a, b, c] = triangle;
        const GridPoint one = a + b - c, several = mean_parallelogram(triangle, one, sides);
        const GridPoint expected = clamped(off_[0] <= off_[1] ? one : several);
        const Vec3d normal = cross(as_vector(b - a), as_vector(c - a));
        const std::array<std::size_t, 3> axis = axes(normal);
        const int size = std::min(bits_of(largest(b - a)), largest_size);
        const int shape =
            std::clamp(bits_of(std::min(largest(c - a) + largest(c - b), max_lean_coordinate)) - size + 1, 0, 3);
        const GridPoint off = wanted - expected;

        const int u_bits = first_[index(size)][index(shape)].code_length(coder_, bits_of(off[axis[0]]));
        const int v_bits =
            second_[index(size)][index(std::clamp(u_bits - size + 5, 0, 7))].code_length(coder_, bits_of(off[axis[1]]));
        const std::int32_t u = NumberModel::code_below(coder_, off[axis[0]], u_bits);
        const std::int32_t v = NumberModel::code_below(coder_, off[axis[1]], v_bits);
        const double upright = normal[static_cast<int>(axis[2])];
        const std::int32_t on_plane =
            upright == 0.0
                ? 0
                : rounded(-(normal[static_cast<int>(axis[0])] * u + normal[static_cast<int>(axis[1])] * v) / upright);
        const int reach = std::clamp(std::max(u_bits, v_bits) - size + 4, 0, 7);
        const std::int32_t height =
            heights_[index(std::min(bend, largest_size))][index(reach)].code(coder_, off[axis[2]] - on_plane);
        GridPoint result{};
        result[axis[0]] = u;
        result[axis[1]] = v;
        result[axis[2]] = height + on_plane;
        result = result + expected;
        learn(result, one, several);
        bend = bits_of(height);
        return result;
    }

    // The corners of a first triangle, each from the one before.
    GridPoint code_first(const GridPoint& wanted, const GridPoint& before, std::size_t corner) {
        GridPoint result = before;
        std::size_t equal = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::int32_t off = first_triangles_[corner][k][equal].code(coder_, wanted[k] - before[k]);
            equal += off == 0 ? 1 : 0;
            result[k] += off;
        }
        return result;
    }

  private:
    static constexpr int largest_size = 19;
    static GridPoint clamped(GridPoint p) {
        for (std::int32_t& x : p) x = std::clamp(x, -max_lean_coordinate, max_lean_coordinate);
        return p;
    }
    static std::size_t index(int i) { return static_cast<std::size_t>(i); }

    // The parallelogram over the last triangle, and those that the neighbours along the border span.
    static GridPoint mean_parallelogram(const std::array<GridPoint, 3>& triangle, const GridPoint& one,
                                        const std::array<Side, 2>& sides) {
        constexpr std::int32_t own_weight = 4, most_weight = 4;
        constexpr std::array<std::int32_t, angle::count + 1> weights{2, most_weight, 3, 2, 1, 1, 0, 0, 0, 0};
        constexpr int share_bits = 32;
        constexpr auto shares = [] {
            std::array<std::int64_t, own_weight + 2 * most_weight + 1> result{};
            for (std::size_t total = own_weight; total < result.size(); ++total)
                result[total] = (std::int64_t{1} << share_bits) / static_cast<std::int64_t>(total);
            return result;
        }();
        const std::int32_t first = weights[sides[0].angle], second = weights[sides[1].angle];
        const std::int64_t share = shares[static_cast<std::size_t>(own_weight + first + second)];
        GridPoint result{};
        for (std::size_t k = 0; k < 3; ++k) {
            const std::int64_t sum = own_weight * std::int64_t{one[k]} +
                                     first * (std::int64_t{triangle[1][k]} + sides[0].neighbour[k] - triangle[0][k]) +
                                     second * (std::int64_t{triangle[0][k]} + sides[1].neighbour[k] - triangle[1][k]);
            result[k] = static_cast<std::int32_t>((sum * share + (std::int64_t{1} << (share_bits - 1))) >> share_bits);
        }
        return result;
    }

    // The one that is steepest to the plane last.
    static std::array<std::size_t, 3> axes(const Vec3d& normal) {
        const double x = std::abs(normal.x), y = std::abs(normal.y), z = std::abs(normal.z);
        const std::size_t last = z > std::max(x, y) ? 2 : y > x ? 1 : 0;
        constexpr std::array<std::array<std::size_t, 3>, 3> orders{{{1, 2, 0}, {2, 0, 1}, {0, 1, 2}}};
        return orders[last];
    }

    // Which expectation has been the better one of late.
    void learn(const GridPoint& result, const GridPoint& one, const GridPoint& several) {
        constexpr int memory = 32, unit = 256;
        const auto bits_off = [&](const GridPoint& expected) {
            const GridPoint off = result - expected;
            return unit * std::bit_width(std::uint64_t{0} + static_cast<std::uint32_t>(std::abs(off[0])) +
                                         static_cast<std::uint32_t>(std::abs(off[1])) +
                                         static_cast<std::uint32_t>(std::abs(off[2])));
        };
        off_[0] += bits_off(one) - off_[0] / memory;
        off_[1] += bits_off(several) - off_[1] / memory;
    }

    Coder& coder_;
    std::array<std::int64_t, 2> off_{};
    std::array<std::array<NumberModel, 4>, largest_size + 1> first_;
    std::array<std::array<NumberModel, 8>, largest_size + 1> second_, heights_;
    std::array<std::array<std::array<NumberModel, 3>, 3>, 3> first_triangles_;
};

// Tells a mesh, or hears it: the same walk over its surface, whatever the coder's direction is.
template <class Coder>
class Walk {
  public:
    // `source`: of an encoder.
    Walk(Coder& coder, LeanMesh& mesh, Source* source)
        : coder_(coder), source_(source), mesh_(mesh), position_coder_(coder) {
        // By what lies at the blunter side, as on levels of many models.
        for (std::size_t where = 0; where < is_fresh_.size(); ++where) {
            const bool is_sharp_there = where >= angle::least_urgent && where <= angle::sharpest;
            const Decision fresh(where >= angle::count ? 20 : is_sharp_there ? 40 : 95, seen_before);
            for (auto& decisions : is_fresh_[where]) decisions.fill(fresh);
        }
        for (std::size_t where = 0; where < otherwise_.size(); ++where) {
            constexpr SymbolModel::Weights known{0, 30, 0, 60, 10}, sharp{0, 85, 0, 12, 3}, end{0, 1, 0, 4, 95};
            const bool is_sharp_there = where >= angle::least_urgent && where <= angle::sharpest;
            otherwise_[where] = SymbolModel(where >= angle::count ? end : is_sharp_there ? sharp : known, seen_before);
        }
    }

    void run(std::uint32_t triangles, std::uint64_t max_points) {
        max_points_ = max_points;
        has_attributes_ = !mesh_.attributes.empty();
        mesh_.triangles.reserve(triangles);
        const std::size_t about = triangles / 2 + triangles / 16 + 16;
        mesh_.positions.reserve(about);
        states_.reserve(about);
        if (has_attributes_) mesh_.position_of_point.reserve(about);
        for (LeanAttribute& attribute : mesh_.attributes) attribute.values.reserve(about * attribute.components());
        while (mesh_.triangles.size() < triangles) {
            if (const std::uint32_t gate = next_gate(); gate != none)
                pass(gate);
            else
                start();
        }
        if (has_attributes_) return;
        mesh_.position_of_point.resize(mesh_.positions.size());
        std::iota(mesh_.position_of_point.begin(), mesh_.position_of_point.end(), 0u);
    }

  private:
    static constexpr std::uint16_t seen_before = 6;  // what beginnings of models are taken for

    using Three = std::array<std::uint32_t, 3>;

    // An edge of the border, triangle on one side of it. Gates lie in rings: each begins where the one before ends.
    struct Gate {
        Three positions;                    // its ends and the triangle's third corner
        Vec3f edge, across;                 // from its beginning to its end, and to the third corner
        std::array<std::uint32_t, 2> next;  // gates along the border: before, after
        std::uint8_t angle;                 // of the corner where it begins
        bool is_open = true;                // until it is known that nothing is beyond it
        bool is_used = true;
    };

    struct PositionState {
        std::uint32_t gate = none;        // the last one that began here
        std::uint32_t last_point = none;  // at this position
        std::uint8_t triangles = 0;       // around it, 255 at most
        std::uint8_t bend = 0;            // bits that it was off the plane before it
    };

    // ---- what is told ----

    void start() {
        const std::uint32_t corner = ask([&] { return source_->first_untold(); });
        Three positions{}, points{};
        for (std::uint32_t k = 0; k < 3; ++k) {
            const std::uint32_t known = ask([&] { return source_->position_number(corner + k); });
            if (!mesh_.positions.empty() && coder_.decide(is_known_[k], known != none)) {
                positions[k] = code_recent(known_first_, known);
                points[k] = code_point(positions[k], states_[positions[k]].last_point, corner + k, {none, none, none});
            } else {
                const GridPoint before = k > 0 ? mesh_.positions[positions[k - 1]] : last_start_;
                const GridPoint place =
                    position_coder_.code_first(ask([&] { return source_->place(corner + k); }), before, k);
                positions[k] = add_position(place, bits_of(std::min(largest(place - before), max_lean_coordinate)) / 2,
                                            corner + k);
                points[k] = add_point(positions[k], corner + k, {none, none, none});
            }
        }
        last_start_ = mesh_.positions[positions[0]];
        if (positions[0] == positions[1] || positions[1] == positions[2] || positions[2] == positions[0])
            throw Damaged{};
        add_first_triangle(points, positions, corner);
        Three gates{};
        for (std::size_t k = 0; k < 3; ++k) gates[k] = add_gate(rotated(positions, k), rotated(points, k));
        for (std::size_t k = 0; k < 3; ++k) link(gates[k], gates[(k + 1) % 3]);
        for (const std::uint32_t gate : gates) measure(gate);
        for (const std::uint32_t gate : gates) enqueue(gate);
    }

    // What is beyond a gate.
    enum class Beyond : std::uint8_t {
        sharper,  // a triangle whose third corner is the border's next one, beside the gate's sharper end
        blunter,  // beside its other end
        fresh,    // a position not told before
        known,    // one told before, elsewhere
        nothing
    };

    // Tells what is beyond a gate.
    void pass(std::uint32_t number) {
        const Gate gate = gates_[number];
        const Sides sides = sides_of(gate, number);
        const std::uint32_t corner = ask([&] { return source_->across(gate.positions[1], gate.positions[0]); });
        const std::uint32_t known = ask([&] { return corner == none ? none : source_->position_number(corner); });

        const std::size_t sharper = sides.sharpness(1) >= sides.sharpness(0) ? 1 : 0;
        const Beyond beyond = code_beyond(gate, sides, sharper, ask([&] {
                                              return corner == none                          ? Beyond::nothing
                                                     : known == none                         ? Beyond::fresh
                                                     : known == sides.neighbour[sharper]     ? Beyond::sharper
                                                     : known == sides.neighbour[1 - sharper] ? Beyond::blunter
                                                                                             : Beyond::known;
                                          }));
        if (beyond == Beyond::nothing) {
            gates_[number].is_open = false;
            return;
        }
        if (beyond == Beyond::fresh) {
            const std::uint32_t third = code_new(gate, sides, corner);
            return add_opening(number, gate, third, corner, true);
        }
        if (beyond == Beyond::known) {
            const std::uint32_t third = code_recent(known_later_, known);
            if (third == gate.positions[0] || third == gate.positions[1]) throw Damaged{};
            return add_opening(number, gate, third, corner, false);
        }
        const std::size_t side = beyond == Beyond::sharper ? sharper : 1 - sharper;
        const std::uint32_t third = sides.neighbour[side];
        const std::uint32_t expected = has_attributes_ ? points_[gate.next[side]][side] : none;
        const Three points = code_points(number, third, expected, corner);
        add_triangle(points, {gate.positions[1], gate.positions[0], third}, corner);
        close(number, gate, side, third, points);
    }

    void add_opening(std::uint32_t number, const Gate& gate, std::uint32_t third, std::uint32_t corner, bool is_new) {
        const Three points = code_points(number, third, is_new ? none : states_[third].last_point, corner);
        add_triangle(points, {gate.positions[1], gate.positions[0], third}, corner);
        open(number, gate, third, points, is_new);
    }

    // The border's next corners on either side of a gate, which a triangle may close.
    struct Sides {
        std::array<std::uint32_t, 2> neighbour{none, none};  // position at the other end of the next gate
        std::array<std::uint8_t, 2> angle{angle::unknown, angle::unknown};
        std::array<bool, 2> is_open{};  // the next gate

        bool is_known(std::size_t s) const { return angle[s] != angle::unknown; }
        int sharpness(std::size_t s) const { return sharpness_of[angle[s]]; }
        static constexpr std::array<std::int8_t, angle::count + 1> sharpness_of{0, 1, 2, 3, 4, 5, 6, 7, -1, -2};
    };

    Sides sides_of(const Gate& gate, std::uint32_t number) const {
        const Gate& before = gates_[gate.next[0]];
        const Gate& after = gates_[gate.next[1]];
        Sides sides;
        const auto set = [&](std::size_t s, const Gate& next, bool is_other, std::uint32_t neighbour,
                             std::uint8_t angle) {
            sides.is_open[s] = next.is_open;
            if (!next.is_open || !is_other || neighbour == gate.positions[1 - s] || angle == angle::unknown) return;
            sides.neighbour[s] = neighbour;
            sides.angle[s] = angle;
        };
        set(0, before, gate.next[0] != number, before.positions[0], gate.angle);
        set(1, after, gate.next[1] != number, after.positions[1], after.angle);
        return sides;
    }

    // First whether the sharper side closes, which most often tells all, then the rest.
    Beyond code_beyond(const Gate& gate, const Sides& sides, std::size_t sharper, Beyond beyond) {
        const std::size_t blunter = 1 - sharper;
        const auto around = [&](std::size_t s) {
            return static_cast<std::size_t>(std::clamp(states_[gate.positions[s]].triangles - 3, 0, 3));
        };
        if (sides.is_known(sharper)) {
            const int other = sides.sharpness(blunter);
            const std::size_t context = other < 0 ? 0 : other < 4 ? 1 : 2;
            Decision& closes = closes_[sides.angle[sharper]][context][around(sharper)];
            if (coder_.decide(closes, beyond == Beyond::sharper)) return Beyond::sharper;
        }
        const auto border = [&](std::size_t s) { return sides.is_known(s) ? 0u : sides.is_open[s] ? 2u : 1u; };
        const std::size_t where = sides.is_known(blunter) ? sides.angle[blunter] : angle::count - 1 + border(blunter);
        if (coder_.decide(is_fresh_[where][border(sharper)][around(blunter)], beyond == Beyond::fresh))
            return Beyond::fresh;
        const auto told = static_cast<Beyond>(coder_.symbol(otherwise_[where], static_cast<std::size_t>(beyond)));
        if (told == Beyond::blunter ? !sides.is_known(blunter) : told != Beyond::known && told != Beyond::nothing)
            throw Damaged{};
        return told;
    }

    // A position that was told before, by how long ago.
    std::uint32_t code_recent(NumberModel& model, std::uint32_t known) {
        const auto count = static_cast<std::int64_t>(mesh_.positions.size());
        const std::int32_t ago = model.code(coder_, static_cast<std::int32_t>(count - 1 - known));
        if (ago < 0 || ago >= count) throw Damaged{};
        return static_cast<std::uint32_t>(count - 1 - ago);
    }

    std::uint32_t code_new(const Gate& gate, const Sides& sides, std::uint32_t corner) {
        std::array<GridPoint, 3> triangle{};
        int bend = 1;
        for (std::size_t k = 0; k < 3; ++k) {
            triangle[k] = mesh_.positions[gate.positions[k]];
            bend += states_[gate.positions[k]].bend;
        }
        bend /= 3;
        std::array<typename PositionCoder<Coder>::Side, 2> known{};
        for (std::size_t s = 0; s < 2; ++s)
            if (sides.is_known(s)) known[s] = {sides.angle[s], mesh_.positions[sides.neighbour[s]]};
        const GridPoint place =
            position_coder_.code(ask([&] { return source_->place(corner); }), triangle, known, bend);
        return add_position(place, bend, corner);
    }

    // The points of the triangle beyond a gate: at the gate's ends and at its third corner. `expected`: none where that
    // is a new position.
    Three code_points(std::uint32_t number, std::uint32_t third, std::uint32_t expected, std::uint32_t corner) {
        if (!has_attributes_) return {gates_[number].positions[0], gates_[number].positions[1], third};
        const Three& ends = gates_[number].positions;
        const Three known = points_[number];
        Three points = known;
        // The triangle is (second end, first end, third), and its third corner comes last.
        const std::uint32_t second = Source::following(corner), first = Source::following(second);
        points[1] = code_point(ends[1], known[1], second, {none, none, none});
        points[0] = code_point(ends[0], known[0], first, {none, none, none});
        const bool is_smooth = points[0] == known[0] && points[1] == known[1];
        const Three from{points[0], points[1], is_smooth ? known[2] : none};
        points[2] = expected == none ? add_point(third, corner, from) : code_point(third, expected, corner, from);
        return points;
    }

    // One at a position that has some. `from`: the points of the edge across of it, and the point on its other side.
    std::uint32_t code_point(std::uint32_t position, std::uint32_t expected, std::uint32_t corner, const Three& from) {
        if (!has_attributes_) return position;
        const std::uint32_t wanted = ask([&] { return source_->point_number(corner); });
        if (coder_.decide(is_expected_, wanted == expected)) return expected;
        std::uint32_t point = states_[position].last_point;
        for (int i = 0; i < max_compared_points && point != none; ++i, point = earlier_points_[point])
            if (point != expected && coder_.decide(is_this_, wanted == point)) return point;
        return add_point(position, corner, from);
    }

    void code_values(std::uint32_t point, std::uint32_t corner, const Three& from) {
        for (std::size_t a = 0; a < mesh_.attributes.size(); ++a) {
            LeanAttribute& attribute = mesh_.attributes[a];
            std::array<std::int32_t, 4> expected{};
            const bool is_inside = from[0] != none;
            if (!is_inside)
                expected = values_of(attribute, point == 0 ? none : point - 1);
            else if (attribute.kind == LeanAttribute::Kind::texture_coordinate)
                expected = expected_coordinate(attribute, point, from);
            else
                expected = expected_color(attribute, from);
            std::int32_t off = 0;
            const std::size_t told = attribute.components() - (attribute.is_opaque ? 1 : 0);
            for (std::size_t c = 0; c < told; ++c) {
                const auto context = static_cast<std::size_t>(std::min(bits_of(off), 5));
                off = values_[a == 0 ? 0 : 1][c][is_inside ? (from[2] == none ? 1 : 0) : 2][context].code(
                    coder_, ask([&] { return source_->value(a, corner, c); }) - expected[c]);
                const std::int32_t value = expected[c] + off;
                if (!is_value(attribute.kind, value)) throw Damaged{};
                attribute.values.push_back(value);
            }
            if (attribute.is_opaque) attribute.values.push_back(opaque);
        }
    }

    static std::array<std::int32_t, 4> values_of(const LeanAttribute& attribute, std::uint32_t point) {
        std::array<std::int32_t, 4> result{};
        if (point == none) return result;
        for (std::size_t c = 0; c < attribute.components(); ++c)
            result[c] = attribute.values[point * attribute.components() + c];
        return result;
    }

    static std::array<std::int32_t, 4> expected_color(const LeanAttribute& attribute, const Three& from) {
        const auto a = values_of(attribute, from[0]), b = values_of(attribute, from[1]);
        const auto c = values_of(attribute, from[2] == none ? from[0] : from[2]);
        std::array<std::int32_t, 4> result{};
        for (std::size_t k = 0; k < result.size(); ++k) result[k] = std::clamp(a[k] + b[k] - c[k], 0, 255);
        return result;
    }

    // Where a triangle of the same shape has it on the image, on the other side of its edge than the last one.
    std::array<std::int32_t, 4> expected_coordinate(const LeanAttribute& attribute, std::uint32_t point,
                                                    const Three& from) const {
        const auto place = [&](std::uint32_t p) -> const GridPoint& {
            return mesh_.positions[mesh_.position_of_point[p]];
        };
        const auto a = values_of(attribute, from[0]), b = values_of(attribute, from[1]);
        const GridPoint edge = place(from[1]) - place(from[0]), to = place(point) - place(from[0]);
        const auto square = static_cast<double>(dot(edge, edge));
        if (square == 0.0) return b;
        const double along = static_cast<double>(dot(edge, to)) / square;
        const double x = b[0] - a[0], y = b[1] - a[1];
        double across = 0.0;
        if (from[2] != none) {
            const auto c = values_of(attribute, from[2]);
            const double side = x * (c[1] - a[1]) - y * (c[0] - a[0]);
            const double distance = static_cast<double>(dot(to, to)) / square - along * along;
            across = std::copysign(std::sqrt(std::max(distance, 0.0)), -side);
        }
        return {rounded(a[0] + along * x - across * y), rounded(a[1] + along * y + across * x), 0, 0};
    }

    // ---- what is known ----

    // What the encoder's source says; nothing in the decoder.
    template <class Question>
    auto ask(const Question& question) const {
        if constexpr (Coder::decodes)
            return decltype(question()){};
        else
            return question();
    }

    template <class Action>
    void note(const Action& action) {
        if constexpr (!Coder::decodes) action();
    }

    std::uint32_t add_position(const GridPoint& place, int bend, std::uint32_t corner) {
        if (!is_within(place[0]) || !is_within(place[1]) || !is_within(place[2])) throw Damaged{};
        const auto number = static_cast<std::uint32_t>(mesh_.positions.size());
        if (!has_attributes_ && number >= max_points_) throw TooMany{};
        mesh_.positions.push_back(place);
        states_.push_back({none, none, 0, static_cast<std::uint8_t>(bend)});
        note([&] { source_->number_position(corner, number); });
        return number;
    }

    std::uint32_t add_point(std::uint32_t position, std::uint32_t corner, const Three& from) {
        if (!has_attributes_) return position;
        const auto number = static_cast<std::uint32_t>(mesh_.position_of_point.size());
        if (number >= max_points_) throw TooMany{};
        mesh_.position_of_point.push_back(position);
        earlier_points_.push_back(states_[position].last_point);
        code_values(number, corner, from);
        states_[position].last_point = number;
        note([&] { source_->number_point(corner, number); });
        return number;
    }

    // `corner`: of an encoder, the third one's. `points`: as of a gate, so the second comes first.
    void add_triangle(const Three& points, const Three& positions, std::uint32_t corner) {
        add_first_triangle({points[1], points[0], points[2]}, positions,
                           corner == none ? none : Source::following(corner));
    }

    // `corner`: of an encoder, the first one's.
    void add_first_triangle(const Three& points, const Three& positions, std::uint32_t corner) {
        mesh_.triangles.push_back(points);
        for (const std::uint32_t p : positions) {
            std::uint8_t& triangles = states_[p].triangles;
            triangles = static_cast<std::uint8_t>(triangles + (triangles < 255 ? 1 : 0));
        }
        note([&] {
            source_->tell(corner);
            for (std::uint32_t k = 0; k < 3; ++k, corner = Source::following(corner))
                source_->told_corners.push_back(corner);
        });
    }

    static Three rotated(const Three& of, std::size_t k) { return {of[k], of[(k + 1) % 3], of[(k + 2) % 3]}; }

    // ---- the border ----

    std::uint32_t add_gate(const Three& positions, const Three& points) {
        auto number = static_cast<std::uint32_t>(gates_.size());
        if (released_.empty()) {
            gates_.emplace_back();
            if (has_attributes_) points_.emplace_back();
        } else {
            number = released_.back();
            released_.pop_back();
        }
        set_gate(number, positions, points);
        return number;
    }

    void set_gate(std::uint32_t number, const Three& positions, const Three& points) {
        Gate& gate = gates_[number];
        gate.positions = positions;
        const GridPoint& from = mesh_.positions[positions[0]];
        gate.edge = between(from, mesh_.positions[positions[1]]);
        gate.across = between(from, mesh_.positions[positions[2]]);
        gate.angle = angle::unknown;
        gate.is_open = gate.is_used = true;
        if (has_attributes_) points_[number] = points;
        states_[positions[0]].gate = number;
    }

    void release(std::uint32_t number) {
        gates_[number].is_open = gates_[number].is_used = false;
        released_.push_back(number);
    }

    void link(std::uint32_t before, std::uint32_t after) {
        gates_[before].next[1] = after;
        gates_[after].next[0] = before;
    }

    // The triangle has also the next gate on this side.
    void close(std::uint32_t made, const Gate& gate, std::size_t side, std::uint32_t third, const Three& points) {
        const std::uint32_t beside = gate.next[side];
        std::array<std::uint32_t, 2> next = gate.next;
        next[side] = gates_[beside].next[side];
        release(beside);
        Three positions{gate.positions[0], gate.positions[1], gate.positions[side]};
        Three points_there{points[0], points[1], points[side]};
        positions[side] = third;
        points_there[side] = points[2];
        set_gate(made, positions, points_there);
        link(next[0], made);
        link(made, next[1]);
        settle(made, next[1]);
    }

    // Takes two gates off that are the same edge from both sides, else measures the corners around the first.
    void settle(std::uint32_t made, std::uint32_t after) {
        for (const auto& [first, second] : {std::pair(gates_[made].next[0], made), std::pair(made, after)}) {
            const Gate &a = gates_[first], &b = gates_[second];
            if (first == second || !a.is_open || !b.is_open || a.positions[0] != b.positions[1] ||
                a.positions[1] != b.positions[0])
                continue;
            const std::uint32_t before = a.next[0], behind = b.next[1];
            release(first);
            release(second);
            if (before == second) return;
            link(before, behind);
            measure(behind);
            return;
        }
        measure(made);
        measure(after);
        enqueue(made);
    }

    // The triangle has a new position, or one elsewhere: there the border is parted, or two borders become one.
    void open(std::uint32_t first, const Gate& gate, std::uint32_t third, const Three& points, bool is_new) {
        std::uint32_t there = is_new ? none : states_[third].gate;
        if (there != none && (!gates_[there].is_used || gates_[there].positions[0] != third)) there = none;
        set_gate(first, {gate.positions[0], third, gate.positions[1]}, {points[0], points[2], points[1]});
        const std::uint32_t second =
            add_gate({third, gate.positions[1], gate.positions[0]}, {points[2], points[1], points[0]});
        link(gate.next[0], first);
        link(second, gate.next[1]);
        if (there != none && there != gate.next[1]) {
            const std::uint32_t before = gates_[there].next[0];
            link(first, there);
            link(before, second);
            measure(there);
        } else {
            link(first, second);
        }
        measure(first);
        measure(gate.next[1]);
        if (is_new)
            gates_[second].angle = angle::reflex;
        else
            measure(second);
        enqueue(first);
        enqueue(second);
    }

    // The angle where a gate begins.
    void measure(std::uint32_t number) {
        Gate& gate = gates_[number];
        const Gate& before = gates_[gate.next[0]];
        if (!gate.is_open || !before.is_open) return;
        gate.angle = angle_between(gate.edge, -before.edge, gate.across);
    }

    // Gates beside a sharp corner come first, the last ones before all.
    void enqueue(std::uint32_t number) {
        const Gate& gate = gates_[number];
        const Gate& after = gates_[gate.next[1]];
        const bool is_urgent =
            (is_sharp(gate.angle) && gates_[gate.next[0]].is_open) || (is_sharp(after.angle) && after.is_open);
        urgent_.push_if(is_urgent, number);
        waiting_.push_if(!is_urgent, number);
    }

    static bool is_sharp(std::uint8_t angle) { return angle >= angle::least_urgent && angle <= angle::sharpest; }

    std::uint32_t next_gate() {
        while (urgent_.size > 0 || next_waiting_ < waiting_.size) {
            const std::uint32_t number =
                urgent_.size > 0 ? urgent_.numbers[--urgent_.size] : waiting_.numbers[next_waiting_++];
            if (gates_[number].is_open) return number;
        }
        waiting_.size = next_waiting_ = 0;
        return none;
    }

    struct Numbers {
        // Without a branch, which would be foreseen badly.
        void push_if(bool is_wanted, std::uint32_t number) {
            if (size == numbers.size()) numbers.resize(2 * size + 64);
            numbers[size] = number;
            size += is_wanted ? 1 : 0;
        }
        std::vector<std::uint32_t> numbers;
        std::size_t size = 0;
    };

    Coder& coder_;
    Source* source_;
    LeanMesh& mesh_;
    std::vector<PositionState> states_;
    std::vector<std::uint32_t>
        earlier_points_;  // of each point, the one before at its position; where there are attributes
    std::vector<Gate> gates_;
    std::vector<Three> points_;  // of each gate's triangle, where there are attributes
    std::vector<std::uint32_t> released_;
    Numbers urgent_, waiting_;
    std::size_t next_waiting_ = 0;
    std::uint64_t max_points_ = 0;
    bool has_attributes_ = false;
    GridPoint last_start_{};

    PositionCoder<Coder> position_coder_;
    std::array<std::array<std::array<Decision, 4>, 3>, angle::count> closes_;
    std::array<std::array<std::array<Decision, 4>, 3>, angle::count + 2> is_fresh_;
    std::array<SymbolModel, angle::count + 2> otherwise_;
    Decision is_expected_, is_this_;
    std::array<Decision, 3> is_known_;
    NumberModel known_first_, known_later_;
    std::array<std::array<std::array<std::array<NumberModel, 6>, 3>, 4>, 2> values_;
};

// ---- the stream: version, counts, grids, then symbols and whole bits ----

void append(std::vector<std::byte>& bytes, std::span<const std::byte> more) {
    bytes.insert(bytes.end(), more.begin(), more.end());
}

void append_number(std::vector<std::byte>& bytes, std::uint64_t value) {
    for (; value >= 0x80; value >>= 7) bytes.push_back(static_cast<std::byte>((value & 0x7f) | 0x80));
    bytes.push_back(static_cast<std::byte>(value));
}

std::uint64_t take_number(std::span<const std::byte>& bytes) {
    std::uint64_t value = 0;
    for (int shift = 0; shift < 63 && !bytes.empty(); shift += 7) {
        const auto byte = std::to_integer<std::uint64_t>(bytes.front());
        bytes = bytes.subspan(1);
        value |= (byte & 0x7f) << shift;
        if (byte < 0x80) return value;
    }
    throw Damaged{};
}

constexpr std::size_t grid_bytes = 4 * sizeof(float);

void append_grid(std::vector<std::byte>& bytes, const LeanGrid& grid) {
    append(bytes, std::as_bytes(std::span(grid.origin)));
    append(bytes, std::as_bytes(std::span(&grid.step, 1)));
}

LeanGrid take_grid(std::span<const std::byte>& bytes) {
    if (bytes.size() < grid_bytes) throw Damaged{};
    LeanGrid grid;
    std::memcpy(grid.origin.data(), bytes.data(), sizeof grid.origin);
    std::memcpy(&grid.step, bytes.data() + sizeof grid.origin, sizeof grid.step);
    bytes = bytes.subspan(grid_bytes);
    return grid;
}

void append_head(std::vector<std::byte>& bytes, const LeanMesh& mesh, std::size_t triangles) {
    bytes.push_back(version);
    append_number(bytes, triangles);
    append_grid(bytes, mesh.grid);
    append_number(bytes, mesh.attributes.size());
    for (const LeanAttribute& attribute : mesh.attributes) {
        append_number(bytes, attribute.components() - (attribute.is_opaque ? 1 : 0));
        if (attribute.kind == LeanAttribute::Kind::texture_coordinate) append_grid(bytes, attribute.grid);
    }
}

std::uint64_t take_head(std::span<const std::byte>& bytes, LeanMesh& mesh) {
    if (bytes.empty() || bytes[0] != version) throw Damaged{};
    bytes = bytes.subspan(1);
    const std::uint64_t triangles = take_number(bytes);
    mesh.grid = take_grid(bytes);
    const std::uint64_t attributes = take_number(bytes);
    if (attributes > max_attributes) throw Damaged{};
    for (std::uint64_t a = 0; a < attributes; ++a) {
        LeanAttribute& attribute = mesh.attributes.emplace_back();
        const std::uint64_t components = take_number(bytes);
        if (components == static_cast<std::uint64_t>(LeanAttribute::Kind::texture_coordinate)) {
            attribute.kind = LeanAttribute::Kind::texture_coordinate;
            attribute.grid = take_grid(bytes);
        } else {
            attribute.is_opaque = components + 1 == attribute.components();
            if (!attribute.is_opaque && components != attribute.components()) throw Damaged{};
        }
    }
    return triangles;
}

LeanMesh decode(std::span<const std::byte> bytes, std::uint64_t max_points, std::uint64_t max_triangles) {
    LeanMesh mesh;
    const std::uint64_t size = bytes.size(), triangles = take_head(bytes, mesh);
    if (triangles / max_triangles_per_byte > size) throw Damaged{};
    if (triangles > max_triangles) throw TooMany{};
    const std::uint64_t symbols = take_number(bytes);
    if (symbols > bytes.size()) throw Damaged{};
    AdaptiveDecoder decoder(bytes.first(symbols), bytes.subspan(symbols));
    std::make_unique<Walk<AdaptiveDecoder>>(decoder, mesh, nullptr)
        ->run(static_cast<std::uint32_t>(triangles), max_points);
    if (!decoder.is_at_end()) throw Damaged{};
    return mesh;
}

bool is_opaque(const LeanAttribute& attribute) {
    if (attribute.kind != LeanAttribute::Kind::color) return false;
    for (std::size_t i = 3; i < attribute.values.size(); i += 4)
        if (attribute.values[i] != opaque) return false;
    return true;
}

}  // namespace

EncodedLeanMesh encode_lean_mesh(const LeanMesh& mesh) {
    EncodedLeanMesh result;
    result.decoded.grid = mesh.grid;
    for (const LeanAttribute& attribute : mesh.attributes)
        result.decoded.attributes.push_back({attribute.kind, attribute.grid, {}, is_opaque(attribute)});
    Source source(mesh);
    AdaptiveEncoder encoder;
    std::make_unique<Walk<AdaptiveEncoder>>(encoder, result.decoded, &source)
        ->run(static_cast<std::uint32_t>(mesh.triangles.size()), none);
    result.source_corners = std::move(source.told_corners);
    append_head(result.bytes, result.decoded, mesh.triangles.size());
    const std::vector<std::byte> symbols = encoder.symbols();
    append_number(result.bytes, symbols.size());
    append(result.bytes, symbols);
    append(result.bytes, encoder.whole_bits());
    return result;
}

Result<LeanMesh> decode_lean_mesh(std::span<const std::byte> bytes, std::uint64_t max_points,
                                  std::uint64_t max_triangles) {
    try {
        return decode(bytes, max_points, max_triangles);
    } catch (const Damaged&) {
        return invalid_input("lean mesh: damaged");
    } catch (const TooMany&) {
        return fail(ErrorCode::limit_exceeded, "lean mesh: more than " + std::to_string(max_points) + " points or " +
                                                   std::to_string(max_triangles) + " triangles");
    }
}

}  // namespace lodestream::codec
