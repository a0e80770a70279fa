#include "client/report/table.h"

#include <algorithm>
#include <cassert>

#include "client/report/text.h"

namespace lodestream::report {
namespace {

// The columns that people see.
std::vector<std::size_t> shown_columns(const Table& table) {
    std::vector<std::size_t> shown;
    for (std::size_t i = 0; i < table.columns.size(); ++i)
        if (!table.columns[i].label.empty()) shown.push_back(i);
    return shown;
}

bool is_numeric_column(const Table& table, std::size_t column) {
    return std::none_of(table.rows.begin(), table.rows.end(),
                        [&](const auto& row) { return std::holds_alternative<std::string>(row[column]); });
}

std::string cut_to(const std::string& text, std::size_t columns) {
    if (terminal_columns(text) <= columns) return text;
    return std::string(terminal_prefix(text, columns - 1)) + "…";
}

struct TextColumn {
    std::string heading;
    std::vector<std::string> cells;
    std::size_t width = 0;
    bool right = false;
};

TextColumn lay_out(const Table& table, std::size_t column) {
    TextColumn out{table.columns[column].label,
                   {},
                   terminal_columns(table.columns[column].label),
                   is_numeric_column(table, column)};
    for (const auto& row : table.rows) {
        out.cells.push_back(cut_to(format_cell(row[column]), max_terminal_cell));
        out.width = std::max(out.width, terminal_columns(out.cells.back()));
    }
    return out;
}

std::string padded(const std::string& text, const TextColumn& column) {
    const std::string space(column.width - terminal_columns(text), ' ');
    return column.right ? space + text : text + space;
}

std::string trimmed_line(std::string line) {
    line.erase(line.find_last_not_of(' ') + 1);
    return line + "\n";
}

}  // namespace

bool is_number(const Cell& cell) {
    return std::holds_alternative<double>(cell) || std::holds_alternative<std::uint64_t>(cell);
}

std::string format_cell(const Cell& cell) {
    if (const auto* text = std::get_if<std::string>(&cell)) return printable(*text);
    if (const auto* number = std::get_if<double>(&cell)) return format_number(*number);
    if (const auto* count = std::get_if<std::uint64_t>(&cell)) return format_count(*count);
    return "–";
}

std::string to_text(const Table& table, bool color) {
    constexpr const char* gap = "  ";
    std::vector<TextColumn> columns;
    for (const std::size_t column : shown_columns(table)) columns.push_back(lay_out(table, column));

    std::string heading, rule, out;
    for (const TextColumn& column : columns) {
        heading += padded(column.heading, column) + gap;
        for (std::size_t i = 0; i < column.width; ++i) rule += "─";
        rule += gap;
    }
    out += (color ? "\x1b[1m" : "") + trimmed_line(heading) + (color ? "\x1b[0m" : "") + trimmed_line(rule);
    for (std::size_t row = 0; row < table.rows.size(); ++row) {
        std::string line;
        for (const TextColumn& column : columns) line += padded(column.cells[row], column) + gap;
        out += trimmed_line(line);
    }
    return out;
}

std::string to_html(const Table& table, const std::string& caption_html) {
    const std::vector<std::size_t> shown = shown_columns(table);
    std::string out = "<figure class=\"table\"><div tabindex=\"0\"><table>\n<thead><tr>";
    for (const std::size_t column : shown)
        out += std::string(is_numeric_column(table, column) ? "<th scope=\"col\" class=\"n\">" : "<th scope=\"col\">") +
               escape_html(table.columns[column].label) + "</th>";
    out += "</tr></thead>\n<tbody>\n";
    for (const auto& row : table.rows) {
        assert(row.size() == table.columns.size());
        out += "<tr>";
        for (const std::size_t column : shown)
            out += (is_numeric_column(table, column) ? "<td class=\"n\">" : "<td>") +
                   escape_html(format_cell(row[column])) + "</td>";
        out += "</tr>\n";
    }
    return out + "</tbody></table></div><figcaption>" + caption_html + "</figcaption></figure>\n";
}

}  // namespace lodestream::report
