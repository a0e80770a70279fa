// Seeded random numbers that are the same on every machine and with every standard library.
#pragma once

#include <cmath>
#include <cstdint>

#include "common/base/math.h"

namespace lodestream {

// splitmix64: any seed is a good one, and copies go on alike.
class Random {
  public:
    explicit Random(std::uint64_t seed = 0) : state_(seed) {}

    std::uint64_t next() {
        std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ull);
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
        return z ^ (z >> 31);
    }
    double uniform() { return static_cast<double>(next() >> 11) * 0x1p-53; }  // [0, 1)
    double uniform(double low, double high) { return low + (high - low) * uniform(); }
    // Uniform in the logarithm. pre: 0 < low <= high
    double log_uniform(double low, double high) { return low * std::pow(high / low, uniform()); }
    double normal() {  // mean 0, standard deviation 1
        const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
        return radius * std::cos(2.0 * pi * uniform());
    }

  private:
    std::uint64_t state_;
};

}  // namespace lodestream
