#include "server/bake/tile_borders.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/mesh/operations.h"
#include "server/bake/tile_levels.h"

namespace lodestream::bake {

namespace {

constexpr float most_coarsening = 4.0f;  // of a leaf's step on its borders: 1/32 of its mean edge off, at most

// The power of two that the grid's range tells in single precision.
double lattice_step(const codec::QuantizationGrid& grid) {
    return std::exp2(std::round(std::log2(grid.step())));
}

}  // namespace

TileBorders::TileBorders(const mesh::Mesh& mesh, std::vector<std::vector<std::uint32_t>> triangles,
                         const simplify::Executor& executor)
    : mesh_(mesh), triangles_(std::move(triangles)), first_(mesh::weld_positions(mesh.positions)) {
    steps_.assign(triangles_.size(), 0.0);
    std::vector<double> finest(triangles_.size(), 0.0);
    simplify::run(executor, triangles_.size(), [&](std::size_t leaf) {
        if (triangles_[leaf].empty()) return;
        const mesh::Mesh alone = mesh::part(mesh_, triangles_[leaf]);
        steps_[leaf] = lattice_step(tile_grid(alone, {}));
        finest[leaf] = lattice_step(codec::window_of_step(mesh::bounds(alone), 0.0));
    });
    find_borders(std::vector<double>(steps_), finest);
}

// The step of a place is the coarsest of its leaves', as far as the finest of them may lie on it, but none finer than
// all of them can have.
void TileBorders::find_borders(std::span<const double> coarsest, std::span<const double> finest) {
    constexpr std::uint32_t nobody = std::numeric_limits<std::uint32_t>::max(), several = nobody - 1;
    std::vector<std::uint32_t> owners(mesh_.positions.size(), nobody);
    std::vector<float> least(mesh_.positions.size(), 0.0f), most(mesh_.positions.size(), 0.0f),
        possible(mesh_.positions.size(), 0.0f);
    const auto for_each_place = [&](std::size_t leaf, const auto& take) {
        for (const std::uint32_t t : triangles_[leaf])
            for (const std::uint32_t v : mesh_.triangles[t]) take(first_[v]);
    };
    for (std::uint32_t leaf = 0; leaf < triangles_.size(); ++leaf)
        for_each_place(leaf, [&](std::uint32_t place) {
            if (owners[place] == leaf) return;
            const auto own = static_cast<float>(coarsest[leaf]);
            least[place] = owners[place] == nobody ? own : std::min(least[place], own);
            most[place] = std::max(most[place], own);
            possible[place] = std::max(possible[place], static_cast<float>(finest[leaf]));
            owners[place] = owners[place] == nobody ? leaf : several;
        });
    border_steps_.assign(mesh_.positions.size(), 0.0f);
    for (std::size_t place = 0; place < owners.size(); ++place)
        if (owners[place] == several)
            border_steps_[place] = std::max(std::min(most[place], most_coarsening * least[place]), possible[place]);
    for (std::size_t leaf = 0; leaf < triangles_.size(); ++leaf)
        for_each_place(leaf, [&](std::uint32_t place) {
            const double step = border_steps_[place];
            if (step > 0.0) steps_[leaf] = std::min(steps_[leaf], step);
        });
}

mesh::Mesh TileBorders::rounded(std::size_t leaf, mesh::Mesh part) const {
    for (std::size_t t = 0; t < part.triangles.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t v = mesh_.triangles[triangles_[leaf][t]][k];
            const double step = border_steps_[first_[v]];
            if (!(step > 0.0)) continue;
            const Vec3f& position = mesh_.positions[v];
            for (int axis = 0; axis < 3; ++axis)
                part.positions[part.triangles[t][k]][axis] =
                    static_cast<float>(std::round(position[axis] / step) * step);
        }
    return part;
}

codec::QuantizationGrid TileBorders::grid(std::size_t leaf, const mesh::Mesh& rounded) const {
    return codec::window_of_step(mesh::bounds(rounded), steps_[leaf]);
}

}  // namespace lodestream::bake
