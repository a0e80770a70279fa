#include "common/codec/lean_shading.h"

#include <draco/compression/bit_coders/rans_bit_decoder.h>
#include <draco/compression/bit_coders/rans_bit_encoder.h>
#include <draco/compression/entropy/symbol_decoding.h>
#include <draco/compression/entropy/symbol_encoding.h>
#include <draco/core/decoder_buffer.h>
#include <draco/core/encoder_buffer.h>
#include <draco/core/varint_decoding.h>
#include <draco/core/varint_encoding.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace lodestream::codec {
namespace {

using Triangles = std::vector<mesh::Triangle>;
using Symbols = std::vector<std::uint32_t>;

const Vec3f up{0, 1, 0};

// Of one position; beyond them a corner is compared with the last ones.
constexpr std::size_t max_compared = 64;
// Faces that meet at less than this angle are expected to have one normal.
const auto least_cosine_within_group = static_cast<float>(std::cos(radians(40.0)));
// Steps of residuals are powers of this root of two, numbered downwards from 1.
constexpr double step_numbers_an_octave = 4.0;
// Behind everything, since some of the symbols' codes do not notice that their end is missing.
constexpr std::uint8_t end_mark = 0x4c;
// A residual's coordinate is the tangent of half an angle: 179.8 degrees.
constexpr double max_coordinate = 512.0;

// Faces and sums in units of the largest extent, so that no product of two lengths leaves single precision.
float inverse_extent(const std::vector<Vec3f>& positions) {
    Vec3f low(std::numeric_limits<float>::max()), high(-low);
    for (const Vec3f& p : positions) {
        low = glm::min(low, p);
        high = glm::max(high, p);
    }
    const double extent = std::max({double{high.x} - low.x, double{high.y} - low.y, double{high.z} - low.z});
    constexpr double largest = std::numeric_limits<float>::max();
    return extent > 0.0 ? static_cast<float>(std::min(1.0 / extent, largest)) : 1.0f;
}

Vec3f unit_or(const Vec3f& v, const Vec3f& otherwise) {
    const float square = dot(v, v);
    return square > std::numeric_limits<float>::min() ? v * (1.0f / std::sqrt(square)) : otherwise;
}

Vec3d unit_or(const Vec3d& v, const Vec3d& otherwise) {
    const double size = length(v);
    return size > 0.0 && std::isfinite(size) ? v / size : otherwise;
}

double step_of(std::uint8_t number) {
    return std::exp2(-number / step_numbers_an_octave);
}

// The coarsest step that leaves less than the tolerance.
std::uint8_t step_number_for(double tolerance_degrees) {
    const double half = radians(std::clamp(tolerance_degrees, 1e-3, 90.0)) / 2.0;
    return static_cast<std::uint8_t>(std::ceil(-step_numbers_an_octave * std::log2(half)));
}

// Two directions across `n` and each other (Duff et al. 2017).
template <class Vector>
std::array<Vector, 2> frame_around(const Vector& n) {
    using Number = typename Vector::value_type;
    const Number one = 1, sign = std::copysign(one, n.z), a = -one / (sign + n.z), b = n.x * n.y * a;
    return {Vector{one + sign * n.x * n.x * a, sign * b, -sign * n.x}, Vector{b, sign + n.y * n.y * a, -n.y}};
}

// Steps of `normal`'s stereographic coordinates around `base`, signs in the lowest bits.
std::array<std::uint32_t, 2> residual_of(const Vec3d& normal, const Vec3d& base, double step) {
    const std::array<Vec3d, 2> frame = frame_around(base);
    const double scale = 1.0 / std::max(1.0 + dot(normal, base), 1e-9);
    std::array<std::uint32_t, 2> result{};
    for (std::size_t k = 0; k < 2; ++k) {
        const double coordinate = std::clamp(dot(normal, frame[k]) * scale, -max_coordinate, max_coordinate);
        const auto steps = static_cast<std::int32_t>(std::lround(coordinate / step));
        result[k] =
            steps < 0 ? 2 * static_cast<std::uint32_t>(-(steps + 1)) + 1 : 2 * static_cast<std::uint32_t>(steps);
    }
    return result;
}

// Of unit length where `base` is: the inverse of a stereographic projection.
Vec3f moved_by(const Vec3f& base, const std::array<std::uint32_t, 2>& residual, float step) {
    const std::array<Vec3f, 2> frame = frame_around(base);
    std::array<float, 2> p{};
    for (std::size_t k = 0; k < 2; ++k) {
        const std::uint32_t magnitude = residual[k] / 2;
        const auto steps = static_cast<float>(magnitude);
        p[k] = step * (residual[k] % 2 == 0 ? steps : -1.0f - steps);
    }
    const float square = p[0] * p[0] + p[1] * p[1];
    return (2.0f * (p[0] * frame[0] + p[1] * frame[1]) + (1.0f - square) * base) * (1.0f / (1.0f + square));
}

// What a face counts in the mean around a position: its area, as normals have that simplification merged, or the sine
// of its angle there, close to the angle itself, as most programs make normals.
enum class Weights : std::uint8_t { area, sine };

// The triangles around positions, and their Gouraud corners.
class Surface {
  public:
    Surface(const std::vector<Vec3f>& positions, const Triangles& triangles, const std::vector<std::uint8_t>& gouraud,
            Weights weights)
        : positions_(positions),
          triangles_(triangles),
          gouraud_(gouraud),
          weights_(weights),
          scale_(inverse_extent(positions)),
          sums_(positions.size(), Vec3f{0.0f}),
          has_gouraud_(positions.size(), 0) {
        for (std::uint32_t t = 0; t < triangles_.size(); ++t)
            for (std::uint32_t k = 0; k < 3; ++k) has_gouraud_[triangles_[t][k]] |= gouraud_[t];
        for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
            const Vec3f area = cross_product(triangles_[t]);
            for (std::uint32_t k = 0; k < 3; ++k) sums_[triangles_[t][k]] += weighted(area, 3 * t + k);
        }
    }

    // Of the positions that `listed` names, in the order of triangles.
    void list_corners(const std::vector<std::uint8_t>& listed) {
        std::vector<std::uint32_t> found;
        first_.assign(positions_.size() + 1, 0);
        for (std::uint32_t t = 0; t < triangles_.size(); ++t)
            for (std::uint32_t k = 0; k < 3; ++k)
                if (const std::uint32_t p = triangles_[t][k]; listed[p] && gouraud_[t]) {
                    found.push_back(3 * t + k);
                    ++first_[p + 1];
                }
        std::partial_sum(first_.begin(), first_.end(), first_.begin());
        corners_.resize(found.size());
        std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
        for (const std::uint32_t corner : found) corners_[next[triangles_[corner / 3][corner % 3]]++] = corner;
    }

    std::uint32_t positions() const { return static_cast<std::uint32_t>(positions_.size()); }
    bool has_gouraud(std::uint32_t position) const { return has_gouraud_[position] != 0; }
    // pre: listed
    std::span<const std::uint32_t> corners(std::uint32_t position) const {
        return std::span(corners_).subspan(first_[position], first_[position + 1] - first_[position]);
    }
    std::size_t listed_corners() const { return corners_.size(); }
    Vec3f face(std::uint32_t corner) const { return cross_product(triangles_[corner / 3]); }
    // pre: `face` is the corner's
    Vec3f weighted(const Vec3f& face, std::uint32_t corner) const {
        return weights_ == Weights::area ? face : by_sine(face, triangles_[corner / 3], corner % 3);
    }
    // The mean over all faces around a position.
    Vec3f smooth(std::uint32_t position) const { return unit_or(sums_[position], up); }

  private:
    Vec3f cross_product(const mesh::Triangle& t) const {
        const Vec3f a = positions_[t[0]] * scale_;
        return cross(positions_[t[1]] * scale_ - a, positions_[t[2]] * scale_ - a);
    }

    // pre: `area` is the triangle's
    Vec3f by_sine(const Vec3f& area, const mesh::Triangle& t, std::uint32_t k) const {
        const Vec3f at = positions_[t[k]] * scale_;
        const Vec3f a = positions_[t[(k + 1) % 3]] * scale_ - at, b = positions_[t[(k + 2) % 3]] * scale_ - at;
        const float lengths = std::sqrt(dot(a, a) * dot(b, b));
        return lengths > std::numeric_limits<float>::min() ? area * (1.0f / lengths) : Vec3f{0.0f};
    }

    const std::vector<Vec3f>& positions_;
    const Triangles& triangles_;
    const std::vector<std::uint8_t>& gouraud_;
    Weights weights_;
    float scale_;
    std::vector<Vec3f> sums_;
    std::vector<std::uint8_t> has_gouraud_;
    std::vector<std::uint32_t> first_, corners_;
};

// The groups of one position's corners after another.
class Groups {
  public:
    explicit Groups(const Surface& surface) : surface_(surface) {}

    // pre: listed; count > 0
    void start(std::uint32_t position, std::uint32_t count) {
        corners_ = surface_.corners(position);
        count_ = count;
        new_group_ = 0;
        group_.clear();
        unit_faces_.clear();
        bases_.assign(count, Vec3f{0.0f});
    }
    // The group that the next corner is expected in: that of the earlier corner whose face is closest to its own, or a
    // new one. What is sent is by how much that is wrong.
    std::uint32_t expected() {
        const std::uint32_t corner = corners_[group_.size()];
        const Vec3f face = surface_.face(corner), unit = unit_or(face, Vec3f{0.0f});
        std::uint32_t result = std::min(new_group_, count_ - 1);
        float closest = least_cosine_within_group;
        const std::size_t skipped = unit_faces_.size() - std::min(unit_faces_.size(), max_compared);
        for (std::size_t i = skipped; i < unit_faces_.size(); ++i) {
            const float cosine = dot(unit_faces_[i], unit);
            if (cosine <= closest) continue;
            closest = cosine;
            result = group_[i];
        }
        weighted_face_ = surface_.weighted(face, corner);
        unit_faces_.push_back(unit);
        return result;
    }
    // pre: expected() was asked for this corner
    void set(std::uint32_t group) {
        group_.push_back(group);
        bases_[group] += weighted_face_;
        new_group_ = std::max(new_group_, group + 1);
    }
    std::span<const std::uint32_t> corners() const { return corners_; }
    // The mean over the faces of a group's corners.
    Vec3f base(std::uint32_t group) const { return unit_or(bases_[group], up); }

  private:
    const Surface& surface_;
    std::span<const std::uint32_t> corners_;
    std::uint32_t count_ = 1, new_group_ = 0;
    Vec3f weighted_face_{0.0f};
    std::vector<Vec3f> unit_faces_, bases_;
    std::vector<std::uint32_t> group_;
};

// What the stream holds behind the runs, in its order.
struct Code {
    Symbols further_groups;  // of each position with Gouraud corners
    Symbols surprises;       // of each corner of those that have any: its group, from the expected one on
    std::uint8_t step = 0;
    std::vector<std::uint8_t> is_off;  // of each group, whether a residual follows
    Symbols residuals;
};

// How a reader derives normals, and when that is close enough.
struct Derivation {
    Weights weights = Weights::area;
    double tolerance_degrees = 0.0;
    AsDerived as_derived = [](const Vec3f& mean) { return mean; };
};

class Encoder {
  public:
    Encoder(const std::vector<Vec3f>& positions, const Triangles& triangles, const WantedShading& wanted,
            const Derivation& derivation)
        : surface_(positions, triangles, wanted.gouraud, derivation.weights),
          wanted_(wanted),
          derivation_(derivation),
          tolerance_(radians(derivation.tolerance_degrees)) {
        code_.step = step_number_for(derivation.tolerance_degrees);
        sent_.normal_of_corner.resize(3 * triangles.size());
        surface_.list_corners(std::vector<std::uint8_t>(positions.size(), 1));
        for (std::uint32_t p = 0; p < positions.size(); ++p)
            if (surface_.has_gouraud(p)) add_position(p);
    }

    Code code() && { return std::move(code_); }
    SentNormals sent() && { return std::move(sent_); }

  private:
    Vec3d wanted(std::uint32_t corner) const {
        return unit_or(Vec3d(wanted_.normals[wanted_.normal_of_corner[corner]]), Vec3d(up));
    }

    bool is_good(const Vec3d& normal, std::uint32_t corner) const {
        const Vec3d want = wanted(corner);
        const double flat =
            std::acos(std::clamp(dot(Vec3d(unit_or(surface_.face(corner), Vec3f{0.0f})), want), -1.0, 1.0));
        const double allowed = std::clamp(flat, tolerance_, lean_tolerances_where_flat_is_worse * tolerance_);
        return dot(normal, want) >= std::cos(std::min(allowed, pi));
    }

    void add_position(std::uint32_t position) {
        const auto corners = surface_.corners(position);
        std::vector<std::uint32_t> group_of(corners.size(), 0);
        const std::uint32_t count = is_one_group(corners) ? 1 : part(corners, group_of);
        code_.further_groups.push_back(count - 1);
        if (count == 1) return add_group(surface_.smooth(position), corners);
        groups_.start(position, count);
        std::vector<std::vector<std::uint32_t>> members(count);
        for (std::size_t i = 0; i < corners.size(); ++i) {
            code_.surprises.push_back((group_of[i] + count - groups_.expected()) % count);
            groups_.set(group_of[i]);
            members[group_of[i]].push_back(corners[i]);
        }
        for (std::uint32_t g = 0; g < count; ++g) add_group(groups_.base(g), members[g]);
    }

    bool is_one_group(std::span<const std::uint32_t> corners) const {
        const std::uint32_t first = wanted_.normal_of_corner[corners[0]];
        const auto has_first = [&](std::uint32_t c) { return wanted_.normal_of_corner[c] == first; };
        if (std::all_of(corners.begin(), corners.end(), has_first)) return true;
        const Vec3d mean = mean_of(corners);
        return std::all_of(corners.begin(), corners.end(), [&](std::uint32_t c) { return is_close(mean, wanted(c)); });
    }

    // Half of the tolerance, the other half is the residual's.
    bool is_close(const Vec3d& a, const Vec3d& b) const { return dot(a, b) >= std::cos(tolerance_ / 2.0); }

    // Corners join the first group whose first normal is close to their own.
    std::uint32_t part(std::span<const std::uint32_t> corners, std::vector<std::uint32_t>& groups) const {
        std::vector<std::uint32_t> first_of_group;
        for (std::size_t i = 0; i < corners.size(); ++i) {
            const auto joins = [&](std::uint32_t first) {
                return wanted_.normal_of_corner[first] == wanted_.normal_of_corner[corners[i]] ||
                       is_close(wanted(first), wanted(corners[i]));
            };
            const auto skipped =
                static_cast<std::ptrdiff_t>(first_of_group.size() - std::min(first_of_group.size(), max_compared));
            const auto found = std::find_if(first_of_group.begin() + skipped, first_of_group.end(), joins);
            groups[i] = static_cast<std::uint32_t>(found - first_of_group.begin());
            if (found == first_of_group.end()) first_of_group.push_back(corners[i]);
        }
        return static_cast<std::uint32_t>(first_of_group.size());
    }

    Vec3d mean_of(std::span<const std::uint32_t> corners) const {
        Vec3d sum{0.0};
        for (const std::uint32_t c : corners) sum += wanted(c);
        return unit_or(sum, wanted(corners[0]));
    }

    void add_group(const Vec3f& mean_of_faces, std::span<const std::uint32_t> corners) {
        const bool exact = derivation_.tolerance_degrees <= most_degrees_of_exact;
        const Vec3f derived = derivation_.as_derived(mean_of_faces);
        const Vec3d judged(exact ? derived : mean_of_faces);
        const bool good = std::all_of(corners.begin(), corners.end(), [&](auto c) { return is_good(judged, c); });
        const Vec3d mean = mean_of(corners);
        const std::array<std::uint32_t, 2> residual = residual_of(mean, Vec3d(mean_of_faces), step_of(code_.step));
        const Vec3f in_steps = moved_by(mean_of_faces, residual, static_cast<float>(step_of(code_.step)));
        const Vec3f told = exact ? Vec3f(mean) : derivation_.as_derived(in_steps);
        for (const std::uint32_t c : corners)
            sent_.normal_of_corner[c] = static_cast<std::uint32_t>(sent_.normals.size());
        sent_.normals.push_back(good ? derived : told);
        code_.is_off.push_back(good ? 0 : 1);
        if (!good) code_.residuals.insert(code_.residuals.end(), residual.begin(), residual.end());
    }

    Surface surface_;
    Groups groups_{surface_};
    const WantedShading& wanted_;
    const Derivation derivation_;
    double tolerance_;  // radians
    Code code_;
    SentNormals sent_;
};

void put_runs(draco::EncoderBuffer& buffer, const std::vector<std::uint8_t>& gouraud) {
    std::uint8_t is_gouraud = 1;
    for (std::size_t begin = 0, end = 0; begin < gouraud.size(); begin = end, is_gouraud ^= 1) {
        while (end < gouraud.size() && (gouraud[end] != 0) == (is_gouraud != 0)) ++end;
        draco::EncodeVarint(static_cast<std::uint64_t>(end - begin), &buffer);
    }
}

bool read_runs(draco::DecoderBuffer& buffer, std::vector<std::uint8_t>& gouraud, std::size_t triangles) {
    std::uint8_t is_gouraud = 1;
    gouraud.reserve(triangles);
    while (gouraud.size() < triangles) {
        std::uint64_t run = 0;
        if (!draco::DecodeVarint(&run, &buffer) || run > triangles - gouraud.size() ||
            (run == 0 && !(gouraud.empty() && is_gouraud)))
            return false;
        gouraud.insert(gouraud.end(), run, is_gouraud);
        is_gouraud ^= 1;
    }
    return true;
}

// Symbols that are mostly zero, as one byte where all are.
void put_symbols(draco::EncoderBuffer& buffer, const Symbols& symbols, int components) {
    const bool any = std::any_of(symbols.begin(), symbols.end(), [](std::uint32_t s) { return s != 0; });
    buffer.Encode(static_cast<std::uint8_t>(any));
    if (any) draco::EncodeSymbols(symbols.data(), static_cast<int>(symbols.size()), components, nullptr, &buffer);
}

bool read_symbols(draco::DecoderBuffer& buffer, Symbols& symbols, std::size_t count, int components) {
    std::uint8_t any = 0;
    symbols.assign(count, 0);
    if (!buffer.Decode(&any) || any > 1) return false;
    return any == 0 ||
           (count > 0 && draco::DecodeSymbols(static_cast<std::uint32_t>(count), components, &buffer, symbols.data()));
}

void put_flags(draco::EncoderBuffer& buffer, const std::vector<std::uint8_t>& flags) {
    draco::RAnsBitEncoder encoder;
    encoder.StartEncoding();
    for (const std::uint8_t flag : flags) encoder.EncodeBit(flag != 0);
    encoder.EndEncoding(&buffer);
}

// Reads the stream behind the runs.
class Decoder {
  public:
    // `result` has the triangles' shading.
    Decoder(const std::vector<Vec3f>& positions, const Triangles& triangles, draco::DecoderBuffer& buffer,
            Weights weights, LeanShading& result)
        : surface_(positions, triangles, result.gouraud, weights), buffer_(buffer), result_(result) {}

    bool run() {
        std::uint8_t end = 0;
        if (!read_further_groups() || !read_residuals()) return false;
        result_.normals.reserve(surface_.positions());
        for (std::uint32_t p = 0; p < surface_.positions(); ++p) {
            if (further_[p] > 0)
                add_position(p);
            else
                result_.normals.push_back(surface_.has_gouraud(p) ? next_normal(surface_.smooth(p)) : up);
        }
        return buffer_.Decode(&end) && end == end_mark && buffer_.remaining_size() == 0;
    }

  private:
    bool read_further_groups() {
        std::size_t used = 0;
        for (std::uint32_t p = 0; p < surface_.positions(); ++p) used += surface_.has_gouraud(p) ? 1 : 0;
        Symbols further;
        if (!read_symbols(buffer_, further, used, 1)) return false;
        groups_ = used;
        further_.assign(surface_.positions(), 0);
        if (std::any_of(further.begin(), further.end(), [](std::uint32_t f) { return f > 0; })) {
            std::vector<std::uint8_t> listed(surface_.positions(), 0);
            for (std::uint32_t p = 0, next = 0; p < surface_.positions(); ++p) {
                if (surface_.has_gouraud(p)) further_[p] = further[next++];
                listed[p] = further_[p] > 0 ? 1 : 0;
            }
            surface_.list_corners(listed);
            for (std::uint32_t p = 0; p < surface_.positions(); ++p) {
                if (further_[p] > 0 && further_[p] >= surface_.corners(p).size()) return false;
                groups_ += further_[p];
            }
        }
        return read_symbols(buffer_, surprises_, surface_.listed_corners(), 1);
    }

    bool read_residuals() {
        std::uint8_t step = 0;
        draco::RAnsBitDecoder flags;
        if (!buffer_.Decode(&step) || !flags.StartDecoding(&buffer_)) return false;
        step_ = static_cast<float>(step_of(step));
        is_off_.resize(groups_);
        std::size_t off = 0;
        for (std::uint8_t& flag : is_off_) off += flag = flags.DecodeNextBit() ? 1 : 0;
        flags.EndDecoding();
        return read_symbols(buffer_, residuals_, 2 * off, 2);
    }

    // The next group's.
    Vec3f next_normal(const Vec3f& base) {
        if (!is_off_[next_group_++]) return base;
        const std::array residual{residuals_[next_residual_], residuals_[next_residual_ + 1]};
        next_residual_ += 2;
        return moved_by(base, residual, step_);
    }

    // One of several groups; the first one's normal is the position's.
    void add_position(std::uint32_t position) {
        const std::uint32_t count = further_[position] + 1;
        const auto first = static_cast<std::uint32_t>(result_.further_normals.size());
        groups_of_.start(position, count);
        for (const std::uint32_t corner : groups_of_.corners()) {
            const std::uint64_t group = (std::uint64_t{groups_of_.expected()} + surprises_[next_surprise_++]) % count;
            groups_of_.set(static_cast<std::uint32_t>(group));
            if (group > 0) result_.further.push_back({corner, first + static_cast<std::uint32_t>(group) - 1});
        }
        result_.normals.push_back(next_normal(groups_of_.base(0)));
        for (std::uint32_t g = 1; g < count; ++g) result_.further_normals.push_back(next_normal(groups_of_.base(g)));
    }

    Surface surface_;
    Groups groups_of_{surface_};
    draco::DecoderBuffer& buffer_;
    LeanShading& result_;
    std::vector<std::uint32_t> further_;  // groups of each position beside the first
    std::vector<std::uint8_t> is_off_;    // of each group
    Symbols surprises_, residuals_;
    std::size_t groups_ = 0, next_group_ = 0, next_surprise_ = 0, next_residual_ = 0;
    float step_ = 1.0f;
};

std::vector<std::byte> encode_with(Weights weights, const std::vector<Vec3f>& positions, const Triangles& triangles,
                                   const WantedShading& wanted, double tolerance_degrees) {
    const Code code = Encoder(positions, triangles, wanted, {weights, tolerance_degrees}).code();
    draco::EncoderBuffer buffer;
    put_runs(buffer, wanted.gouraud);
    buffer.Encode(weights);
    put_symbols(buffer, code.further_groups, 1);
    put_symbols(buffer, code.surprises, 1);
    buffer.Encode(code.step);
    put_flags(buffer, code.is_off);
    put_symbols(buffer, code.residuals, 2);
    buffer.Encode(end_mark);
    const auto* bytes = reinterpret_cast<const std::byte*>(buffer.data());
    return {bytes, bytes + buffer.size()};
}

}  // namespace

std::vector<std::byte> encode_lean_shading(const std::vector<Vec3f>& positions, const Triangles& triangles,
                                           const WantedShading& wanted, double tolerance_degrees) {
    std::vector<std::byte> by_area = encode_with(Weights::area, positions, triangles, wanted, tolerance_degrees);
    std::vector<std::byte> by_sine = encode_with(Weights::sine, positions, triangles, wanted, tolerance_degrees);
    return by_sine.size() < by_area.size() ? by_sine : by_area;
}

SentNormals sent_normals(const std::vector<Vec3f>& positions, const Triangles& triangles, const WantedShading& wanted,
                         double tolerance_degrees, const AsDerived& as_derived) {
    return Encoder(positions, triangles, wanted, {Weights::area, tolerance_degrees, as_derived}).sent();
}

Result<LeanShading> decode_lean_shading(const std::vector<Vec3f>& positions, const Triangles& triangles,
                                        std::span<const std::byte> bytes) {
    LeanShading result;
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    buffer.set_bitstream_version(DRACO_BITSTREAM_VERSION(2, 2));
    std::uint8_t weights = 0;
    if (!read_runs(buffer, result.gouraud, triangles.size()) || !buffer.Decode(&weights) ||
        weights > static_cast<std::uint8_t>(Weights::sine) ||
        !Decoder(positions, triangles, buffer, static_cast<Weights>(weights), result).run())
        return invalid_input("lean shading: damaged");
    return result;
}

}  // namespace lodestream::codec
