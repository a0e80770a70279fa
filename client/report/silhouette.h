// What a model covers of a picture, pixel by pixel, worked out without drawing it: a crowd of a thousand full scans has
// a thousand million triangles, but its outline is a few thousand pixels long.
//
// Boxes around runs of triangles along the Z-order curve form a tree. What lies in a box that holds no pixel's centre,
// or none that is not covered already, cannot change the picture, so it is left out: the result is exactly that of all
// triangles.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "client/render/image.h"
#include "common/base/raster.h"
#include "common/codec/level_codec.h"

namespace lodestream::report {

// One bit a pixel.
class Mask {
  public:
    Mask() = default;  // of no pixels
    Mask(std::uint32_t width, std::uint32_t height);

    std::uint32_t width() const { return width_; }
    std::uint32_t height() const { return height_; }
    bool at(std::uint32_t x, std::uint32_t y) const { return (word(x, y) >> x % word_bits & 1) != 0; }
    void set(std::uint32_t x, std::uint32_t y) { words_[index(x, y)] |= std::uint64_t{1} << x % word_bits; }
    // Whether all of the rectangle is set.
    bool holds(const PixelRange& columns, const PixelRange& rows) const;
    void join(const Mask& other);                         // pre: of the same size
    std::uint64_t count() const;                          // pixels that are set
    std::uint64_t count_shared(const Mask& other) const;  // set in both. pre: of the same size

  private:
    static constexpr std::uint32_t word_bits = 64;
    std::size_t index(std::uint32_t x, std::uint32_t y) const { return std::size_t{y} * stride_ + x / word_bits; }
    std::uint64_t word(std::uint32_t x, std::uint32_t y) const { return words_[index(x, y)]; }

    std::uint32_t width_ = 0, height_ = 0;
    std::size_t stride_ = 0;  // words of a row
    std::vector<std::uint64_t> words_;
};

// Which pixels of a drawn picture are not white, the background.
Mask silhouette(const render::Image& image);

// Parts of the full model's picture that are not drawn and lie inside its outline: connected over pixels' edges, and
// nothing beside them is outside of the full model. Where a drawing's outline falls short is no hole.
struct Holes {
    std::uint64_t count = 0;
    std::uint64_t pixels = 0;  // of all of them
};
// pre: of the same size
Holes holes_in(const Mask& drawn, const Mask& full);

class SilhouetteTree {
  public:
    // pre: the renderer takes the content (render::check_drawable)
    explicit SilhouetteTree(const codec::Decoded& content);

    // Sets the pixels that the content covers at `offset` from its own place. `pixels_from_world`: as from
    // render::pixels_from_world(). pre: all of it is in front of the eye
    void cover(const Mat4d& pixels_from_world, const Vec3d& offset, Mask& mask) const;

  private:
    using Corners = std::array<Vec3f, 3>;
    struct Node {
        Vec3f min, max;
        std::uint32_t first = 0, count = 0;  // triangles
        std::uint32_t next = 0;              // the node behind this one's own
    };

    void sort_along_curve();
    void build(std::uint32_t first, std::uint32_t count);
    void draw(const Node& node, const Mat4d& pixels_from_content, Mask& mask) const;

    Vec3d origin_{0.0};
    std::vector<Corners> triangles_;
    std::vector<Node> nodes_;  // each before those in it
};

}  // namespace lodestream::report
