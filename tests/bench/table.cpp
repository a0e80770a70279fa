#include "tests/bench/table.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace lodestream::bench {

std::string to_text(const std::vector<TableRow>& rows) {
    std::vector<std::size_t> widths(rows.front().size(), 0);
    for (const TableRow& row : rows)
        for (std::size_t k = 0; k < row.size(); ++k) widths[k] = std::max(widths[k], row[k].size());
    std::string text;
    for (const TableRow& row : rows) {
        for (std::size_t k = 0; k < row.size(); ++k) {
            const std::string padding(widths[k] - row[k].size(), ' ');
            text += k == 0 ? row[k] + padding : "  " + padding + row[k];
        }
        text += '\n';
    }
    return text;
}

std::string fixed(double value, int decimals) {
    char text[64];
    std::snprintf(text, sizeof text, "%.*f", decimals, value);
    return std::isfinite(value) ? text : "-";
}

std::string brief(double value) {
    if (!std::isfinite(value)) return "-";
    const double magnitude = value == 0 ? 0.0 : std::floor(std::log10(std::abs(value)));
    return fixed(value, std::clamp(2 - static_cast<int>(magnitude), 0, 6));
}

}  // namespace lodestream::bench
