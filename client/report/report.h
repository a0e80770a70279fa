// The report: what four classes of device get of every asset, and error against run time for every stage.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "common/base/result.h"

namespace lodestream::report {

struct ReportOptions {
    std::string server_url;     // empty: a server of its own with the built-in samples, stopped at the end
    std::filesystem::path out;  // made where missing; report.html, report.json, pictures/
    std::optional<std::filesystem::path> assets;   // folder of models for that server; not with server_url
    std::optional<std::filesystem::path> methods;  // what the simplification benchmark wrote, to be shown beside ours
    std::optional<std::filesystem::path> codecs;   // what the codec benchmark wrote, likewise
    std::optional<std::filesystem::path> points;   // what the points benchmark wrote, likewise
    std::optional<std::filesystem::path> scenes;   // what the hlod benchmark wrote of growing scenes, likewise
    bool quick = false;                            // models that are ready soon and small, fewer levels and frames
    bool json = false;                             // report.json on stdout instead of the table
    std::string command_line;                      // as typed; printed with every table
};

// Waits until nothing is baking, measures, writes the files and prints one table. Progress on stderr where it is a
// terminal. What fails for one asset is left out and said in the report; nothing measured at all is an error.
Status run(const ReportOptions& options);

}  // namespace lodestream::report
