#include "client/roam/popping.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

namespace lodestream::roam {

Result<Popping> popping_between(const render::Image& before, const render::Image& after) {
    if (before.width != after.width || before.height != after.height || !image::is_consistent(before) ||
        !image::is_consistent(after))
        return invalid_input("pictures to compare must be of one size and not empty");
    std::array<std::uint64_t, 256> pixels{};  // that change by so many steps
    for (std::size_t i = 0; i < before.rgba.size(); i += 4) {
        int change = 0;
        for (std::size_t c = i; c < i + 3; ++c) change = std::max(change, std::abs(before.rgba[c] - after.rgba[c]));
        ++pixels[static_cast<std::size_t>(change)];
    }
    Popping popping;
    const std::uint64_t few = before.pixels() / 1000;
    std::uint64_t as_large = 0;
    double squares = 0.0;
    for (std::size_t step = pixels.size(); step-- > 0;) {
        const auto steps = static_cast<double>(step);
        if (as_large == 0 && pixels[step] > 0) popping.largest = steps;
        if (as_large <= few && as_large + pixels[step] > few) popping.p999 = steps;
        as_large += pixels[step];
        squares += steps * steps * static_cast<double>(pixels[step]);
    }
    popping.rms = std::sqrt(squares / static_cast<double>(before.pixels()));
    return popping;
}

}  // namespace lodestream::roam
