// Plots in a page of their own.
#pragma once

#include <string>
#include <vector>

#include "client/report/plot.h"

namespace lodestream::bench {

// Throws std::runtime_error where the file cannot be written.
void write_plots(const std::string& file, const std::string& title, const std::vector<report::Plot>& plots);

}  // namespace lodestream::bench
