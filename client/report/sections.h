// The report's sections as tables and plots: pure functions of the data.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "client/report/data.h"
#include "client/report/plot.h"
#include "client/report/table.h"

namespace lodestream::report {

// What these bytes take: bytes * 8 / rate, and a round trip each for the plan and the content. Computed.
double link_ms(const Link& link, double bytes);

// Everything at a glance, one row an asset and device: what the terminal shows.
Table overview_table(const ReportData& data);

// Pictures side by side in one, as a benchmark made them.
struct Strip {
    std::string title;
    std::string png_base64;
    std::vector<std::string> labels{};  // of each, equally wide; empty: the title says it all
};

// Keyed as in report.json.
struct Section {
    std::string key;
    std::string title;
    std::string text_html;  // what it shows and how to read it; trusted HTML
    std::vector<Plot> plots;
    std::vector<Plot> folded_plots;  // more of the same for who wants them
    Table rows;                      // all of them, as report.json has them
    std::optional<Table> shown;      // what the page shows instead, where the rows are too many to read
    std::vector<Strip> strips{};
};

std::vector<Section> sections(const ReportData& data);

// The findings in plain words, most important first; trusted HTML, one sentence or two each.
std::vector<std::string> summary_html(const ReportData& data);

}  // namespace lodestream::report
