#include "client/report/silhouette.h"

#include <algorithm>
#include <bit>

#include "common/base/z_order.h"

namespace lodestream::report {
namespace {

constexpr std::uint32_t leaf_triangles = 4;
constexpr double curve_cells = 1u << 20;  // along each axis

Vec3d pixel_of(const Mat4d& pixels_from_content, const Vec3f& position) {
    const Vec4d p = pixels_from_content * Vec4d(Vec3d(position), 1.0);
    return Vec3d(p.x, p.y, 0.0) / p.w;
}

// The pixels whose centres the picture of a box may hold.
struct Rectangle {
    PixelRange columns, rows;
};

Rectangle rectangle_of(const Mat4d& pixels_from_content, const Vec3f& min, const Vec3f& max, const Mask& mask) {
    Box seen;
    for (unsigned corner = 0; corner < 8; ++corner)
        seen.add(pixel_of(pixels_from_content,
                          {corner & 1 ? max.x : min.x, corner & 2 ? max.y : min.y, corner & 4 ? max.z : min.z}));
    return {pixels_between(seen.min.x, seen.max.x, mask.width()),
            pixels_between(seen.min.y, seen.max.y, mask.height())};
}

}  // namespace

Mask::Mask(std::uint32_t width, std::uint32_t height)
    : width_(width), height_(height), stride_((std::size_t{width} + word_bits - 1) / word_bits) {
    words_.resize(stride_ * height);
}

bool Mask::holds(const PixelRange& columns, const PixelRange& rows) const {
    for (std::uint32_t y = rows.first; y < rows.last; ++y)
        for (std::uint32_t x = columns.first; x < columns.last; x += word_bits - x % word_bits) {
            const std::uint32_t bits = std::min(word_bits - x % word_bits, columns.last - x);
            const std::uint64_t wanted = (~std::uint64_t{0} >> (word_bits - bits)) << x % word_bits;
            if ((word(x, y) & wanted) != wanted) return false;
        }
    return true;
}

void Mask::join(const Mask& other) {
    for (std::size_t i = 0; i < words_.size(); ++i) words_[i] |= other.words_[i];
}

std::uint64_t Mask::count() const {
    return count_shared(*this);
}

std::uint64_t Mask::count_shared(const Mask& other) const {
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < words_.size(); ++i)
        sum += static_cast<std::uint64_t>(std::popcount(words_[i] & other.words_[i]));
    return sum;
}

Mask silhouette(const render::Image& image) {
    Mask mask(image.width, image.height);
    const std::uint8_t* rgba = image.rgba.data();
    for (std::uint32_t y = 0; y < image.height; ++y)
        for (std::uint32_t x = 0; x < image.width; ++x, rgba += 4)
            if (rgba[0] != 255 || rgba[1] != 255 || rgba[2] != 255) mask.set(x, y);
    return mask;
}

Holes holes_in(const Mask& drawn, const Mask& full) {
    struct Pixel {
        std::uint32_t x = 0, y = 0;
    };
    Holes holes;
    Mask looked_at = drawn;
    std::vector<Pixel> part;
    bool is_inside = true;
    const auto visit = [&](std::uint32_t x, std::uint32_t y) {
        if (x >= full.width() || y >= full.height() || !full.at(x, y)) {
            is_inside = false;
        } else if (!looked_at.at(x, y)) {
            looked_at.set(x, y);
            part.push_back({x, y});
        }
    };
    for (std::uint32_t y = 0; y < full.height(); ++y)
        for (std::uint32_t x = 0; x < full.width(); ++x) {
            if (!full.at(x, y) || looked_at.at(x, y)) continue;
            part.clear();
            is_inside = true;
            visit(x, y);
            for (std::size_t i = 0; i < part.size(); ++i) {
                const auto [px, py] = part[i];
                visit(px - 1, py), visit(px + 1, py), visit(px, py - 1), visit(px, py + 1);  // below 0 wraps
            }
            if (!is_inside) continue;
            ++holes.count;
            holes.pixels += part.size();
        }
    return holes;
}

SilhouetteTree::SilhouetteTree(const codec::Decoded& content) : origin_(content.origin) {
    for (const codec::Primitive& primitive : content.primitives)
        for (const mesh::Triangle& t : primitive.mesh.triangles)
            triangles_.push_back(
                {primitive.mesh.positions[t[0]], primitive.mesh.positions[t[1]], primitive.mesh.positions[t[2]]});
    sort_along_curve();
    if (!triangles_.empty()) build(0, static_cast<std::uint32_t>(triangles_.size()));
}

void SilhouetteTree::sort_along_curve() {
    Box box;
    for (const Corners& t : triangles_)
        for (const Vec3f& corner : t) box.add(Vec3d(corner));
    const Vec3d extent = box.extent();
    const double longest = std::max({extent.x, extent.y, extent.z, std::numeric_limits<double>::min()});
    const auto place = [&](const Corners& t) {
        const Vec3d center = (Vec3d(t[0]) + Vec3d(t[1]) + Vec3d(t[2])) / 3.0 - box.min;
        const auto cell = [&](double x) {
            return static_cast<std::uint64_t>(std::clamp(x / longest * curve_cells, 0.0, curve_cells - 1.0));
        };
        return z_order(cell(center.x), cell(center.y), cell(center.z));
    };
    std::vector<std::pair<std::uint64_t, Corners>> placed;
    placed.reserve(triangles_.size());
    for (const Corners& t : triangles_) placed.emplace_back(place(t), t);
    std::stable_sort(placed.begin(), placed.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    std::ranges::transform(placed, triangles_.begin(), [](const auto& p) { return p.second; });
}

void SilhouetteTree::build(std::uint32_t first, std::uint32_t count) {
    const std::size_t here = nodes_.size();
    Node node{triangles_[first][0], triangles_[first][0], first, count, 0};
    for (std::uint32_t t = first; t < first + count; ++t)
        for (const Vec3f& corner : triangles_[t]) {
            node.min = min(node.min, corner);
            node.max = max(node.max, corner);
        }
    nodes_.push_back(node);
    if (count > leaf_triangles) {
        build(first, count / 2);
        build(first + count / 2, count - count / 2);
    }
    nodes_[here].next = static_cast<std::uint32_t>(nodes_.size());
}

void SilhouetteTree::cover(const Mat4d& pixels_from_world, const Vec3d& offset, Mask& mask) const {
    Mat4d from_content = pixels_from_world;
    from_content[3] = pixels_from_world * Vec4d(origin_ + offset, 1.0);
    for (std::uint32_t i = 0; i < nodes_.size();) {
        const Node& node = nodes_[i];
        const auto [columns, rows] = rectangle_of(from_content, node.min, node.max, mask);
        if (columns.empty() || rows.empty() || mask.holds(columns, rows)) {
            i = node.next;
        } else {
            if (node.count <= leaf_triangles) draw(node, from_content, mask);
            ++i;
        }
    }
}

void SilhouetteTree::draw(const Node& node, const Mat4d& pixels_from_content, Mask& mask) const {
    for (std::uint32_t t = node.first; t < node.first + node.count; ++t) {
        std::array<Vec3d, 3> seen;
        for (std::size_t k = 0; k < 3; ++k) seen[k] = pixel_of(pixels_from_content, triangles_[t][k]);
        for_each_pixel(seen, mask.width(), mask.height(), [&](std::uint32_t x, std::uint32_t y) { mask.set(x, y); });
    }
}

}  // namespace lodestream::report
