// Plain text tables: first column to the left, the others to the right.
#pragma once

#include <string>
#include <vector>

namespace lodestream::bench {

using TableRow = std::vector<std::string>;

// pre: every row has as many cells as the first, which is the heading
std::string to_text(const std::vector<TableRow>& rows);

std::string fixed(double value, int decimals);
// Three significant digits; "-" where not finite.
std::string brief(double value);

}  // namespace lodestream::bench
