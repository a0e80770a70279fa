#include "common/image/pack.h"

#include <algorithm>
#include <cmath>
#include <limits>

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#define STB_RECT_PACK_IMPLEMENTATION
#define STBRP_STATIC
#include <stb/stb_rect_pack.h>
#pragma GCC diagnostic pop

namespace lodestream::image {

namespace {

constexpr double width_shares[] = {0.6, 0.75, 0.9, 1.05, 1.2, 1.4};  // of the side of a square of the rectangles' area

PackedSize size_of(const std::vector<stbrp_rect>& rects) {
    PackedSize size;
    for (const stbrp_rect& rect : rects) {
        size.width = std::max(size.width, static_cast<std::uint32_t>(rect.x + rect.w));
        size.height = std::max(size.height, static_cast<std::uint32_t>(rect.y + rect.h));
    }
    return size;
}

std::uint64_t area_of(const PackedSize& size) {
    return std::uint64_t{size.width} * size.height;
}

std::vector<stbrp_rect> packed(std::vector<stbrp_rect> rects, std::uint32_t width, int limit) {
    std::vector<stbrp_node> nodes(width);
    stbrp_context context;
    stbrp_init_target(&context, static_cast<int>(width), limit, nodes.data(), static_cast<int>(nodes.size()));
    stbrp_setup_heuristic(&context, STBRP_HEURISTIC_Skyline_BF_sortHeight);
    stbrp_pack_rects(&context, rects.data(), static_cast<int>(rects.size()));
    return rects;
}

}  // namespace

PackedSize pack(std::vector<Rectangle>& rectangles) {
    if (rectangles.empty()) return {};
    std::vector<stbrp_rect> rects;
    double area = 0.0;
    std::uint32_t widest = 1;
    std::uint64_t height = 0;
    for (const Rectangle& r : rectangles) {
        stbrp_rect& rect = rects.emplace_back();
        rect.w = static_cast<stbrp_coord>(r.width);
        rect.h = static_cast<stbrp_coord>(r.height);
        area += static_cast<double>(r.width) * r.height;
        widest = std::max(widest, r.width);
        height += r.height;
    }
    const auto limit = static_cast<int>(std::min<std::uint64_t>(height, std::numeric_limits<int>::max()));
    std::vector<stbrp_rect> best;
    for (const double share : width_shares) {
        const auto width = std::max(widest, static_cast<std::uint32_t>(std::ceil(share * std::sqrt(area))));
        std::vector<stbrp_rect> next = packed(rects, width, limit);
        if (best.empty() || area_of(size_of(next)) < area_of(size_of(best))) best = std::move(next);
    }
    for (std::size_t i = 0; i < rectangles.size(); ++i) {
        rectangles[i].x = static_cast<std::uint32_t>(best[i].x);
        rectangles[i].y = static_cast<std::uint32_t>(best[i].y);
    }
    return size_of(best);
}

}  // namespace lodestream::image
