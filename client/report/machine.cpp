#include "client/report/machine.h"

#include <ctime>
#include <fstream>
#include <thread>

#include "client/report/commit.h"
#include "client/report/text.h"

namespace lodestream::report {
namespace {

std::string cpu_model() {
    std::ifstream file("/proc/cpuinfo");
    for (std::string line; std::getline(file, line);)
        if (line.starts_with("model name")) {
            const std::size_t at = line.find(": ");
            if (at != std::string::npos) return line.substr(at + 2);
        }
    return "unknown CPU";
}

std::string utc_now() {
    const std::time_t now = std::time(nullptr);
    std::tm parts{};
    char buffer[32] = "";
    if (gmtime_r(&now, &parts)) std::strftime(buffer, sizeof buffer, "%Y-%m-%dT%H:%M:%SZ", &parts);
    return buffer;
}

std::string machine_text(const Provenance& from) {
    const std::string machine = from.cpu + ", " + std::to_string(from.cores) + (from.cores == 1 ? " core" : " cores");
    if (from.renderer.empty()) return machine;
    return machine + "; " + from.renderer + (from.software_renderer ? " (drawn by the CPU)" : "");
}

}  // namespace

Provenance provenance_of(std::string command) {
    Provenance from;
    from.command = std::move(command);
    from.commit = built_commit();
    from.date = utc_now();
    from.cpu = cpu_model();
    from.cores = std::thread::hardware_concurrency();
    return from;
}

Provenance provenance_of(const proto::RunOrigin& origin) {
    Provenance from;
    from.command = origin.command;
    from.commit = origin.commit;
    from.date = origin.date;
    from.cpu = origin.cpu;
    from.cores = origin.cores;
    return from;
}

std::string source_line(const Provenance& from) {
    return "<code>" + escape_html(from.command) + "</code> · commit " + escape_html(from.commit) + " · " +
           escape_html(machine_text(from)) + " · " + escape_html(from.date);
}

std::string joined(int argc, const char* const* argv) {
    std::string line;
    for (int i = 0; i < argc; ++i) {
        if (i > 0) line += ' ';
        line += argv[i];
    }
    return line;
}

}  // namespace lodestream::report
