// A table of named cells: one description that the terminal, the HTML page and the JSON file show alike.
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

namespace lodestream::report {

using Cell = std::variant<std::monostate, std::string, double, std::uint64_t>;  // monostate: nothing to say

struct Column {
    std::string key;    // field name in JSON, with its unit
    std::string label;  // heading for people; empty: in JSON only
};

struct Table {
    std::vector<Column> columns;
    std::vector<std::vector<Cell>> rows;  // each as long as `columns`
};

bool is_number(const Cell& cell);
std::string format_cell(const Cell& cell);  // printable text; nothing and non-finite numbers: "–"

inline constexpr std::size_t max_terminal_cell = 24;  // columns; longer ones are cut with "…"

// Aligned columns, numbers to the right, headings underlined; ANSI bold for the headings where `color`.
std::string to_text(const Table& table, bool color);

// A <figure class="table"> that scrolls on its own: heading row, numbers in class "n", below it `caption_html`, which
// is trusted HTML.
std::string to_html(const Table& table, const std::string& caption_html);

}  // namespace lodestream::report
