#include "common/texture/choice.h"

#include <cmath>
#include <queue>
#include <utility>

namespace lodestream::texture {
namespace {

// How far down its ladder an image is: 0 is the image itself, n the n-th of its sizes.
using Rung = std::size_t;

std::uint64_t bytes_at(const mesh::Image& image, const Sizes& sizes, Rung rung) {
    return rung == 0 ? image.bytes.size() : sizes[rung - 1].image.bytes.size();
}

Rung within_a_pixel(const Sizes& sizes, double texel_size, double pixel_size) {
    Rung rung = 0;
    while (rung < sizes.size() && std::ldexp(texel_size, sizes[rung].halvings) <= pixel_size) ++rung;
    return rung;
}

// Takes the image of the most bytes a rung down until all fit.
void fit(const mesh::Model& model, const Ladder& ladder, double max_bytes, std::uint64_t& bytes,
         std::vector<Rung>& rungs) {
    std::priority_queue<std::pair<std::uint64_t, std::size_t>> heaviest;
    const auto push = [&](std::size_t i) {
        if (rungs[i] < ladder[i].size()) heaviest.push({bytes_at(model.images[i], ladder[i], rungs[i]), i});
    };
    for (std::size_t i = 0; i < rungs.size(); ++i) push(i);
    while (static_cast<double>(bytes) > max_bytes && !heaviest.empty()) {
        const auto [before, i] = heaviest.top();
        heaviest.pop();
        bytes -= before - bytes_at(model.images[i], ladder[i], ++rungs[i]);
        push(i);
    }
}

}  // namespace

Textures textures_of(Ladder ladder, std::vector<ImageUse> uses, std::vector<double> texel_sizes) {
    ladder.resize(uses.size());
    Textures textures{std::move(ladder), std::move(uses), std::move(texel_sizes)};
    for (std::size_t i = 0; i < textures.uses.size(); ++i)
        if (!textures.uses[i].is_used) textures.ladder[i].clear();
    return textures;
}

Textures textures_of(const mesh::Model& model, Ladder ladder) {
    return textures_of(std::move(ladder), image_uses(model), texel_sizes(model));
}

Choice choose(const mesh::Model& model, const Textures& textures, const Needs& needs) {
    const Ladder& ladder = textures.ladder;
    Choice choice;
    choice.images.resize(model.images.size());
    std::vector<Rung> rungs(model.images.size(), 0);
    for (std::size_t i = 0; i < rungs.size(); ++i) {
        if (!textures.uses[i].is_used) continue;
        if (needs.pixel_size > 0.0) rungs[i] = within_a_pixel(ladder[i], textures.texel_sizes[i], needs.pixel_size);
        const std::uint64_t bytes = bytes_at(model.images[i], ladder[i], rungs[i]);
        choice.images[i].bytes_below_a_pixel = model.images[i].bytes.size() - bytes;
        choice.bytes += bytes;
    }
    fit(model, ladder, needs.max_bytes, choice.bytes, rungs);
    for (std::size_t i = 0; i < rungs.size(); ++i) {
        if (rungs[i] == 0) continue;
        choice.images[i].image = &ladder[i][rungs[i] - 1].image;
        choice.key.append(".").append(std::to_string(i)).append("-").append(std::to_string(rungs[i]));
    }
    return choice;
}

}  // namespace lodestream::texture
