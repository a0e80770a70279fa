#include "client/report/table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "client/report/text.h"

namespace lodestream::report {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

Table small_table() {
    return {
        {{"asset", "model"}, {"triangles", "triangles"}, {"hidden", ""}, {"error", "error %"}},
        {{std::string("teapot"), std::uint64_t{6400}, 1.0, 0.25}, {std::string("é"), std::uint64_t{7}, 2.0, Cell{}}}};
}

std::vector<std::string> lines_of(const std::string& text) {
    std::vector<std::string> lines;
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    return lines;
}

TEST(Table, AlignsNumbersRightAndTextLeftInColumnsOfOneWidth) {
    EXPECT_EQ(to_text(small_table(), false),
              "model   triangles  error %\n"
              "──────  ─────────  ───────\n"
              "teapot      6,400     0.25\n"
              "é               7        –\n");
}

TEST(Table, ColoursOnlyWhereAsked) {
    EXPECT_THAT(to_text(small_table(), false), Not(HasSubstr("\x1b")));
    EXPECT_THAT(to_text(small_table(), true), HasSubstr("\x1b[1m"));
}

TEST(Table, ANameOfAThousandCharactersDoesNotWidenTheTable) {
    Table table = small_table();
    table.rows[0][0] = std::string(1000, 'x');
    for (const std::string& line : lines_of(to_text(table, false)))
        EXPECT_LE(terminal_columns(line), max_terminal_cell + 20);
}

TEST(Table, NamesInWideScriptsStayAligned) {
    Table table = small_table();
    table.rows[0][0] = std::string("찻주전자");
    const std::vector<std::string> lines = lines_of(to_text(table, false));
    EXPECT_EQ(terminal_columns(lines[2]), terminal_columns(lines[3]));
    table.rows[0][0] = std::string("찻주전자찻주전자찻주전자찻주전자");
    EXPECT_THAT(to_text(table, false), HasSubstr("찻주전자찻주전자찻주전…  "));
}

TEST(Table, ANameCannotSendTerminalCommandsOrBreakItsLine) {
    Table table = small_table();
    table.rows[0][0] = std::string("\x1b]0;owned\x07\n");
    const std::string text = to_text(table, false);
    EXPECT_THAT(text, Not(HasSubstr("\x1b")));
    EXPECT_EQ(lines_of(text).size(), 4u);
}

TEST(Table, WithoutRowsItIsItsHeadings) {
    Table table = small_table();
    table.rows.clear();
    EXPECT_EQ(lines_of(to_text(table, false)).size(), 2u);
    EXPECT_THAT(to_html(table, ""), HasSubstr("<tbody>\n</tbody>"));
}

TEST(Table, HtmlEscapesCellsAndHidesColumnsWithoutALabel) {
    Table table = small_table();
    table.rows[0][0] = std::string("<img src=x onerror=alert(1)>");
    const std::string html = to_html(table, "caption");
    EXPECT_THAT(html, Not(HasSubstr("<img")));
    EXPECT_THAT(html, HasSubstr("&lt;img src=x onerror=alert(1)&gt;"));
    EXPECT_THAT(html, Not(HasSubstr("hidden")));
    EXPECT_THAT(html, HasSubstr("<td class=\"n\">6,400</td>"));
}

TEST(Table, CellsThatAreNotFiniteAreADash) {
    EXPECT_EQ(format_cell(Cell{std::nan("")}), "–");
    EXPECT_EQ(format_cell(Cell{}), "–");
}

}  // namespace
}  // namespace lodestream::report
