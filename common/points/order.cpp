#include "common/points/order.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "common/base/z_order.h"

namespace lodestream::points {

namespace {

constexpr int max_octaves = 21;       // cells of 2^-20 of the extent in the last
constexpr int passes_per_octave = 8;  // the distance falls by 2^(1/8) between two passes
constexpr std::size_t candidates_per_cell = 32;
constexpr float widest_spacing = 2.0f;           // the first pass
constexpr int block_octaves = 3;                 // a block's side is 2^3 cells
constexpr std::size_t worth_sharing = 1u << 14;  // candidates, between several threads
constexpr std::size_t colors = 8;                // blocks of one colour, of each two along every axis, do not touch
constexpr std::uint32_t none = 0xffffffffu;

using Cell = std::array<std::uint32_t, 3>;

// Everything below is in units of the cloud's longest side, from its lowest corner.
struct Source {
    std::vector<Vec3f> places;       // in [0, 1], along the Z-order curve
    std::vector<Cell> cells;         // likewise, the smallest ones
    std::vector<Vec3f> normals;      // likewise; empty: none
    std::vector<std::uint32_t> ids;  // of the given cloud
    double unit = 1.0;
};

Cell smallest_cell(const Vec3f& place) {
    constexpr double cells = 1u << max_octaves;
    const auto along = [](float x) { return static_cast<std::uint32_t>(std::clamp(x * cells, 0.0, cells - 1.0)); };
    return {along(place.x), along(place.y), along(place.z)};
}

// The cell of an octave that holds this smallest one.
Cell cell_at(const Cell& smallest, int octave) {
    const int shift = max_octaves - octave;
    return {smallest[0] >> shift, smallest[1] >> shift, smallest[2] >> shift};
}

std::uint64_t z_order(const Cell& cell) {
    return lodestream::z_order(cell[0], cell[1], cell[2]);
}

Source source_of(const PointCloud& cloud) {
    Box box;
    for (const Vec3f& p : cloud.positions) box.add(Vec3d(p));
    const Vec3d extent = box.extent();
    Source source;
    source.unit = std::max({extent.x, extent.y, extent.z});
    if (!(source.unit > 0.0)) source.unit = 1.0;
    const auto place = [&](std::uint32_t id) { return Vec3f((Vec3d(cloud.positions[id]) - box.min) / source.unit); };
    std::vector<std::pair<std::uint64_t, std::uint32_t>> sorted(cloud.positions.size());
    for (std::uint32_t id = 0; id < sorted.size(); ++id) sorted[id] = {z_order(smallest_cell(place(id))), id};
    std::sort(sorted.begin(), sorted.end());
    for (const auto& [code, id] : sorted) {
        source.places.push_back(place(id));
        source.cells.push_back(smallest_cell(source.places.back()));
        source.ids.push_back(id);
        if (!cloud.normals.empty()) source.normals.push_back(cloud.normals[id]);
    }
    return source;
}

struct Candidate {
    Vec3f place{0.0f};
    float nearest = std::numeric_limits<float>::infinity();  // squared distance to what was taken
    Vec3f normal{0.0f};
    std::uint32_t at = 0;  // in the source
};

// Candidates that lie in one block, which are neighbours in the source's order.
struct Block {
    std::uint32_t first = 0, last = 0;
};

// Candidates by cell, found by the cell's coordinates.
class Grid {
  public:
    Grid(const Source& source, int octave, std::size_t stride) : source_(source), octave_(octave) {
        for (std::size_t at = 0; at < source.places.size(); at += stride) {
            candidates.push_back({source.places[at], std::numeric_limits<float>::infinity(), normal_at(at),
                                  static_cast<std::uint32_t>(at)});
            const std::uint64_t key = packed(cell_at(source.cells[at], octave));
            if (!keys_.empty() && keys_.back() == key) continue;
            keys_.push_back(key);
            firsts_.push_back(static_cast<std::uint32_t>(candidates.size() - 1));
            add_to_blocks(source.cells[at], firsts_.back());
        }
        if (last_block_) last_block_->last = static_cast<std::uint32_t>(candidates.size());
        firsts_.push_back(static_cast<std::uint32_t>(candidates.size()));
        slots_.assign(std::bit_ceil(2 * keys_.size() + 1), none);
        for (std::uint32_t cell = 0; cell < keys_.size(); ++cell) slots_[slot_of(keys_[cell])] = cell;
    }

    // Tells the candidates around that this point of the source was taken.
    void take(std::uint32_t at) {
        const auto [x, y, z] = cell_at(source_.cells[at], octave_);
        const std::uint32_t last = (1u << octave_) - 1;
        for (std::uint32_t cz = z - (z > 0); cz <= std::min(z + 1, last); ++cz)
            for (std::uint32_t cy = y - (y > 0); cy <= std::min(y + 1, last); ++cy)
                for (std::uint32_t cx = x - (x > 0); cx <= std::min(x + 1, last); ++cx) {
                    const std::uint32_t cell = slots_[slot_of(packed({cx, cy, cz}))];
                    if (cell != none) take_in(cell, source_.places[at], normal_at(at));
                }
    }

    std::vector<Candidate> candidates;  // in the order of the source
    // What is taken in one block changes candidates in it and in cells next to it alone, so the blocks of one colour
    // may be gone through side by side.
    std::array<std::vector<Block>, colors> blocks;

  private:
    void add_to_blocks(const Cell& smallest, std::uint32_t candidate) {
        const Cell block = cell_at(smallest, std::max(octave_ - block_octaves, 0));
        if (last_block_ && block == last_place_) return;
        if (last_block_) last_block_->last = candidate;
        std::vector<Block>& of_color = blocks[(block[0] & 1u) | (block[1] & 1u) << 1 | (block[2] & 1u) << 2];
        last_block_ = &of_color.emplace_back(Block{candidate, candidate});
        last_place_ = block;
    }
    static std::uint64_t packed(const Cell& cell) {
        return cell[0] | std::uint64_t{cell[1]} << max_octaves | std::uint64_t{cell[2]} << (2 * max_octaves);
    }
    Vec3f normal_at(std::size_t at) const { return source_.normals.empty() ? Vec3f(0.0f) : source_.normals[at]; }

    // Of the cell with this key, or the free one where it would be.
    std::size_t slot_of(std::uint64_t key) const {
        const std::size_t mask = slots_.size() - 1;
        std::size_t slot = (key * 0x9e3779b97f4a7c15ull >> 20) & mask;
        while (slots_[slot] != none && keys_[slots_[slot]] != key) slot = (slot + 1) & mask;
        return slot;
    }

    void take_in(std::uint32_t cell, const Vec3f& place, const Vec3f& normal) {
        for (std::uint32_t i = firsts_[cell]; i < firsts_[cell + 1]; ++i) {
            Candidate& candidate = candidates[i];
            const Vec3f apart = candidate.place - place;
            const float squared = dot(apart, apart);
            if (squared < candidate.nearest && (dot(candidate.normal, normal) >= 0.0f || squared == 0.0f))
                candidate.nearest = squared;
        }
    }

    const Source& source_;
    int octave_;
    Block* last_block_ = nullptr;  // while it is being filled
    Cell last_place_{none, none, none};
    std::vector<std::uint64_t> keys_;
    std::vector<std::uint32_t> firsts_;  // candidate of each cell, and one past the last
    std::vector<std::uint32_t> slots_;   // cells; a power of two of them
};

std::size_t occupied_cells(const Source& source, int octave) {
    std::size_t cells = 0;
    Cell before{none, none, none};
    for (const Cell& smallest : source.cells) {
        const Cell cell = cell_at(smallest, octave);
        cells += cell != before;
        before = cell;
    }
    return cells;
}

// Neighbours along the curve come far apart: the order of the bits' reversal.
std::vector<std::uint32_t> spread_out(const std::vector<std::uint32_t>& along_curve) {
    std::vector<std::uint32_t> result;
    result.reserve(along_curve.size());
    const int bits = std::bit_width(along_curve.size());
    for (std::uint32_t k = 0; k < (1u << bits); ++k) {
        std::uint32_t reversed = 0;
        for (int bit = 0; bit < bits; ++bit) reversed |= (k >> bit & 1u) << (bits - 1 - bit);
        if (reversed < along_curve.size()) result.push_back(along_curve[reversed]);
    }
    return result;
}

class Ordering {
  public:
    Ordering(const Source& source, std::uint64_t count, const simplify::Executor& executor)
        : source_(source), count_(std::min<std::uint64_t>(count, source.places.size())), executor_(executor) {}

    void run() {
        if (count_ == 0) return;
        taken_.push_back(central());
        spacings_.push_back(widest_spacing);
        for (int octave = 0; octave < max_octaves && taken_.size() < count_; ++octave) take_octave(octave);
    }

    const std::vector<std::uint32_t>& taken() const { return taken_; }  // places in the source
    const std::vector<float>& spacings() const { return spacings_; }

  private:
    std::uint32_t central() const {
        Vec3f high(0.0f);
        for (const Vec3f& p : source_.places) high = max(high, p);
        const auto from_center = [&](const Vec3f& p) { return dot(p - 0.5f * high, p - 0.5f * high); };
        const auto nearest =
            std::min_element(source_.places.begin(), source_.places.end(),
                             [&](const Vec3f& a, const Vec3f& b) { return from_center(a) < from_center(b); });
        return static_cast<std::uint32_t>(nearest - source_.places.begin());
    }

    // All distances of [2^-octave, 2^(1 - octave)), from the largest down; the first octave also the larger ones.
    void take_octave(int octave) {
        const std::size_t wanted = candidates_per_cell * occupied_cells(source_, octave);
        // Odd, so that points that come in pairs take turns.
        Grid grid(source_, octave, source_.places.size() / wanted | 1u);
        for (const std::uint32_t at : taken_) grid.take(at);
        for (int pass = octave == 0 ? -passes_per_octave : 0; pass < passes_per_octave; ++pass) {
            if (taken_.size() >= count_) return;
            take_pass(grid, std::exp2(-octave - static_cast<double>(pass) / passes_per_octave));
        }
    }

    void take_pass(Grid& grid, double spacing) {
        std::vector<std::uint32_t> found;
        for (const std::vector<Block>& blocks : grid.blocks) {
            std::vector<std::vector<std::uint32_t>> found_in(blocks.size());
            const auto take = [&](std::size_t k) { found_in[k] = take_in_block(grid, blocks[k], spacing); };
            simplify::run(grid.candidates.size() < worth_sharing ? simplify::Executor{} : executor_, blocks.size(),
                          take);
            for (const std::vector<std::uint32_t>& part : found_in) found.insert(found.end(), part.begin(), part.end());
        }
        std::sort(found.begin(), found.end());
        for (const std::uint32_t at : spread_out(found)) {
            if (taken_.size() >= count_) return;
            taken_.push_back(at);
            spacings_.push_back(static_cast<float>(spacing));
        }
    }

    static std::vector<std::uint32_t> take_in_block(Grid& grid, const Block& block, double spacing) {
        std::vector<std::uint32_t> found;
        for (std::uint32_t i = block.first; i < block.last; ++i) {
            if (grid.candidates[i].nearest < spacing * spacing) continue;
            found.push_back(grid.candidates[i].at);
            grid.take(found.back());
        }
        return found;
    }

    const Source& source_;
    std::uint64_t count_;
    const simplify::Executor& executor_;
    std::vector<std::uint32_t> taken_;
    std::vector<float> spacings_;
};

}  // namespace

OrderedCloud order(const PointCloud& cloud, std::uint64_t count, const simplify::Executor& executor) {
    const Source source = source_of(cloud);
    Ordering ordering(source, count, executor);
    ordering.run();
    OrderedCloud ordered;
    for (const std::uint32_t at : ordering.taken()) {
        const std::uint32_t id = source.ids[at];
        ordered.cloud.positions.push_back(cloud.positions[id]);
        if (!cloud.normals.empty()) ordered.cloud.normals.push_back(cloud.normals[id]);
        if (!cloud.colors.empty()) ordered.cloud.colors.push_back(cloud.colors[id]);
    }
    for (const float spacing : ordering.spacings())
        ordered.spacings.push_back(static_cast<float>(spacing * source.unit));
    return ordered;
}

}  // namespace lodestream::points
