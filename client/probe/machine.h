// What the system says of itself.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "common/budget/budget.h"

namespace lodestream::probe {

struct Machine {
    std::string name;               // the processor's
    std::optional<double> cpu_mhz;  // the fastest core's, as it runs now; some systems do not say
    std::uint32_t cpu_cores = 1;
    std::optional<double> memory_mb;         // what programs may use: of the machine or of the container, the less
    std::optional<budget::Display> display;  // of the first screen that is connected
};

Machine read_machine();

// Of /proc/cpuinfo's text: the first value of a field, "" where there is none; the largest number of a field.
std::string first_value(std::string_view cpuinfo, std::string_view field);
std::optional<double> largest_value(std::string_view cpuinfo, std::string_view field);
// "1920x1080", "1920x1080i"
std::optional<budget::Display> parse_mode(std::string_view mode);

}  // namespace lodestream::probe
