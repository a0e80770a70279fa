// The comparison as text, and the targets of issue 3 against it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tests/bench/comparison.h"

namespace lodestream::bench {

// One row a level and method.
std::string comparison_table(const ModelResult& model);

// Wall over CPU time of the peers, which have one thread each: 1 on a quiet machine. Where it is more, the ratios in
// CPU time say more. NaN without peers.
double busyness(const std::vector<ModelResult>& models);

struct Target {
    std::string what;
    std::optional<double> bound;  // absent: for information
    bool at_least = false;        // the value must not be below the bound; else not above it
};

struct Verdict {
    Target target;
    std::vector<std::string> models;  // those where it could be measured
    std::vector<double> values;

    bool holds(std::size_t model) const;  // pre: the target has a bound
    bool holds() const;                   // on all models; likewise
};

// Those targets whose values were measured at least once.
std::vector<Verdict> verdicts(const std::vector<ModelResult>& models);
std::string verdict_table(const std::vector<Verdict>& verdicts);

}  // namespace lodestream::bench
