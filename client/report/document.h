// The two files of a report.
#pragma once

#include <string>

#include "client/report/data.h"

namespace lodestream::report {

// One self-contained page: style, plots and pictures inside, nothing fetched, light and dark.
std::string html_document(const ReportData& data);

// One key a section with its rows, beside "run" (command, commit, machine) and "problems". All numbers finite or null.
std::string json_document(const ReportData& data);

}  // namespace lodestream::report
