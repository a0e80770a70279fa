#include "common/codec/lean_shading.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/base/packed_normal.h"
#include "common/mesh/operations.h"

namespace lodestream::codec {
namespace {

using Triangles = std::vector<mesh::Triangle>;

constexpr std::size_t max_compared_faces = 64;      // at one position; beyond, all corners there take the whole average
constexpr std::uint32_t steps_between_bytes = 258;  // of a packed normal's coordinate: 16 bits to 8

// Numbers of seven bits a byte, the lowest first; the top bit says that more follow.
void put_number(std::vector<std::byte>& bytes, std::uint64_t number) {
    for (; number >= 0x80; number >>= 7) bytes.push_back(static_cast<std::byte>(number | 0x80));
    bytes.push_back(static_cast<std::byte>(number));
}

void put_normal(std::vector<std::byte>& bytes, const Vec3f& normal) {
    const std::uint32_t packed = pack_normal(normal);
    for (const std::uint32_t half : {packed & 0xffffu, packed >> 16}) {
        const double coordinate = static_cast<std::int16_t>(half);
        bytes.push_back(
            static_cast<std::byte>(static_cast<std::int8_t>(std::lround(coordinate / steps_between_bytes))));
    }
}

// Reads what the two above wrote. After the first failure everything reads as zero.
class ByteReader {
  public:
    explicit ByteReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

    bool failed() const { return failed_; }
    bool at_end() const { return bytes_.empty(); }

    std::uint64_t number() {
        std::uint64_t result = 0;
        for (unsigned shift = 0; shift < 35; shift += 7) {
            const auto byte = std::to_integer<std::uint64_t>(next());
            result |= (byte & 0x7f) << shift;
            if (byte < 0x80) return result;
        }
        failed_ = true;
        return 0;
    }

    Vec3f normal() {
        const auto coordinate = [&] {
            const int steps = static_cast<std::int8_t>(next()) * static_cast<int>(steps_between_bytes);
            return static_cast<std::uint32_t>(static_cast<std::uint16_t>(steps));
        };
        const std::uint32_t u = coordinate(), v = coordinate();
        return unpack_normal(u | v << 16);
    }

  private:
    std::byte next() {
        failed_ = failed_ || bytes_.empty();
        if (failed_) return std::byte{0};
        const std::byte first = bytes_.front();
        bytes_ = bytes_.subspan(1);
        return first;
    }

    std::span<const std::byte> bytes_;
    bool failed_ = false;
};

Vec3f unit_or(const Vec3d& v, const Vec3d& otherwise) {
    const double size = length(v);
    return Vec3f(size > 0.0 && std::isfinite(size) ? v / size : otherwise);
}

class NormalDeriver {
  public:
    NormalDeriver(const std::vector<Vec3f>& positions, const Triangles& triangles)
        : triangles_(triangles), position_(mesh::weld_positions(positions)), sums_(positions.size(), Vec3d{0.0}) {
        faces_.reserve(triangles.size());
        for (const mesh::Triangle& t : triangles) {
            const Vec3d a(positions[t[0]]);
            faces_.push_back(cross(Vec3d(positions[t[1]]) - a, Vec3d(positions[t[2]]) - a));
            units_.push_back(unit_or(faces_.back(), Vec3d{0.0}));
            for (const std::uint32_t v : t) sums_[position_[v]] += faces_.back();
        }
    }

    const std::vector<Vec3f>& face_normals() const { return units_; }

    std::vector<Vec3f> run() {
        std::vector<Vec3f> average(sums_.size(), Vec3f{0.0f});
        for (std::size_t v = 0; v < sums_.size(); ++v)
            if (position_[v] == v) average[v] = unit_or(sums_[v], {0, 1, 0});
        const std::vector<bool> creased = find_creased(average);
        std::vector<Vec3f> normals;
        normals.reserve(3 * triangles_.size());
        for (std::uint32_t t = 0; t < triangles_.size(); ++t)
            for (const std::uint32_t v : triangles_[t])
                normals.push_back(creased[position_[v]] ? within_crease(t, position_[v], average[position_[v]])
                                                        : average[position_[v]]);
        return normals;
    }

  private:
    // Where a face is farther from the average than half the crease, two may be farther from each other than all of it.
    std::vector<bool> find_creased(const std::vector<Vec3f>& average) {
        const auto least = static_cast<float>(std::cos(radians(lean_crease_degrees / 2)));
        std::vector<bool> creased(average.size(), false);
        bool any = false;
        for (std::uint32_t t = 0; t < triangles_.size(); ++t)
            for (const std::uint32_t v : triangles_[t])
                if (units_[t] != Vec3f{0.0f} && dot(units_[t], average[position_[v]]) < least)
                    any = creased[position_[v]] = true;
        if (any) list_faces(creased);
        return creased;
    }

    void list_faces(const std::vector<bool>& creased) {
        first_.assign(creased.size() + 1, 0);
        const auto for_each = [&](const auto& visit) {
            for (std::uint32_t t = 0; t < triangles_.size(); ++t)
                for (const std::uint32_t v : triangles_[t])
                    if (creased[position_[v]]) visit(t, position_[v]);
        };
        for_each([&](std::uint32_t, std::uint32_t at) { ++first_[at + 1]; });
        std::partial_sum(first_.begin(), first_.end(), first_.begin());
        around_.resize(first_.back());
        std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
        for_each([&](std::uint32_t t, std::uint32_t at) { around_[next[at]++] = t; });
    }

    Vec3f within_crease(std::uint32_t triangle, std::uint32_t at, const Vec3f& average) const {
        const auto least = static_cast<float>(std::cos(radians(lean_crease_degrees)));
        const std::span faces(around_.data() + first_[at], first_[at + 1] - first_[at]);
        if (faces.size() > max_compared_faces || units_[triangle] == Vec3f{0.0f}) return average;
        Vec3d sum{0.0};
        for (const std::uint32_t t : faces)
            if (dot(units_[t], units_[triangle]) >= least) sum += faces_[t];
        return unit_or(sum, Vec3d(units_[triangle]));
    }

    const Triangles& triangles_;
    const std::vector<std::uint32_t> position_;  // of each vertex, the first one at its place
    std::vector<Vec3d> faces_, sums_;            // cross products: of each triangle, and summed at each position
    std::vector<Vec3f> units_;                   // of faces_; (0,0,0) where there is no area
    std::vector<std::uint32_t> first_, around_;  // the triangles at creased positions
};

// Normals to be sent: for a vertex, where all its Gouraud corners want the same one, else corner by corner.
struct Corrections {
    std::vector<std::pair<std::uint32_t, Vec3f>> vertices, corners;
};

Corrections find_corrections(const std::vector<Vec3f>& positions, const Triangles& triangles,
                             const LeanShading& wanted) {
    NormalDeriver deriver(positions, triangles);
    const std::vector<Vec3f> derived = deriver.run();
    const std::size_t vertices = positions.size();
    const auto always_good = static_cast<float>(std::cos(radians(lean_always_good_degrees)));
    const auto tolerance = static_cast<float>(std::cos(radians(lean_normal_tolerance_degrees)));
    const auto off = [&](std::uint32_t c) {
        const float flat = dot(deriver.face_normals()[c / 3], wanted.normals[c]);
        return !(dot(derived[c], wanted.normals[c]) >= std::clamp(flat, tolerance, always_good));
    };
    constexpr std::uint32_t none = 0xffffffffu;
    std::vector<std::uint32_t> first_corner(vertices, none);
    std::vector<std::uint8_t> is_off(vertices, 0), differs(vertices, 0);
    const auto for_each_gouraud = [&](const auto& visit) {
        for (std::uint32_t t = 0; t < triangles.size(); ++t)
            for (std::uint32_t k = 0; k < 3 && wanted.gouraud[t]; ++k) visit(3 * t + k, triangles[t][k]);
    };
    for_each_gouraud([&](std::uint32_t c, std::uint32_t v) {
        if (first_corner[v] == none) first_corner[v] = c;
        if (wanted.normals[c] != wanted.normals[first_corner[v]]) differs[v] = 1;
        if (off(c)) is_off[v] = 1;
    });
    Corrections result;
    for (std::uint32_t v = 0; v < vertices; ++v)
        if (is_off[v] && !differs[v]) result.vertices.emplace_back(v, wanted.normals[first_corner[v]]);
    for_each_gouraud([&](std::uint32_t c, std::uint32_t v) {
        if (differs[v] && off(c)) result.corners.emplace_back(c, wanted.normals[c]);
    });
    return result;
}

// `list`: by rising number.
void put_corrections(std::vector<std::byte>& bytes, const std::vector<std::pair<std::uint32_t, Vec3f>>& list) {
    put_number(bytes, list.size());
    std::uint32_t next = 0;
    for (const auto& [number, normal] : list) {
        put_number(bytes, number - next);
        put_normal(bytes, normal);
        next = number + 1;
    }
}

template <class Set>
bool read_corrections(ByteReader& reader, std::uint64_t limit, const Set& set) {
    const std::uint64_t count = reader.number();
    std::uint64_t next = 0;
    for (std::uint64_t i = 0; i < count; ++i) {
        const std::uint64_t number = next + reader.number();
        const Vec3f normal = reader.normal();
        if (reader.failed() || number >= limit) return false;
        set(static_cast<std::uint32_t>(number), normal);
        next = number + 1;
    }
    return !reader.failed();
}

bool read_runs(ByteReader& reader, std::vector<std::uint8_t>& gouraud, std::size_t triangles) {
    std::uint8_t is_gouraud = 1;
    while (gouraud.size() < triangles) {
        const std::uint64_t run = reader.number();
        if (reader.failed() || run > triangles - gouraud.size() || (run == 0 && !(gouraud.empty() && is_gouraud)))
            return false;
        gouraud.insert(gouraud.end(), run, is_gouraud);
        is_gouraud ^= 1;
    }
    return true;
}

}  // namespace

std::vector<Vec3f> derive_normals(const std::vector<Vec3f>& positions, const Triangles& triangles) {
    return NormalDeriver(positions, triangles).run();
}

std::vector<std::byte> encode_lean_shading(const std::vector<Vec3f>& positions, const Triangles& triangles,
                                           const LeanShading& wanted) {
    std::vector<std::byte> bytes;
    std::uint8_t is_gouraud = 1;
    for (std::size_t begin = 0, end = 0; begin < wanted.gouraud.size(); begin = end, is_gouraud ^= 1) {
        while (end < wanted.gouraud.size() && (wanted.gouraud[end] != 0) == (is_gouraud != 0)) ++end;
        put_number(bytes, end - begin);
    }
    const Corrections corrections = find_corrections(positions, triangles, wanted);
    put_corrections(bytes, corrections.vertices);
    put_corrections(bytes, corrections.corners);
    return bytes;
}

Result<LeanShading> decode_lean_shading(const std::vector<Vec3f>& positions, const Triangles& triangles,
                                        std::span<const std::byte> bytes) {
    LeanShading result;
    ByteReader reader(bytes);
    std::vector<Vec3f> at_vertex(positions.size(), Vec3f{0.0f});
    std::vector<std::pair<std::uint32_t, Vec3f>> at_corner;
    const bool sound =
        read_runs(reader, result.gouraud, triangles.size()) &&
        read_corrections(reader, positions.size(), [&](std::uint32_t v, const Vec3f& n) { at_vertex[v] = n; }) &&
        read_corrections(reader, 3 * triangles.size(),
                         [&](std::uint32_t c, const Vec3f& n) { at_corner.emplace_back(c, n); });
    if (!sound || !reader.at_end()) return invalid_input("lean shading: damaged");
    result.normals = derive_normals(positions, triangles);
    for (std::uint32_t t = 0; t < triangles.size(); ++t)
        for (std::uint32_t k = 0; k < 3; ++k)
            if (const Vec3f& n = at_vertex[triangles[t][k]]; n != Vec3f{0.0f}) result.normals[3 * t + k] = n;
    for (const auto& [corner, normal] : at_corner) result.normals[corner] = normal;
    return result;
}

}  // namespace lodestream::codec
