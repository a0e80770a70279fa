#include "tests/bench/plots.h"

#include <fstream>
#include <stdexcept>

namespace lodestream::bench {

namespace {

constexpr const char* page_css =
    ":root{color-scheme:light dark}body{font:16px system-ui,sans-serif;margin:2rem}"
    "figure{max-width:44rem;margin:1rem 0 3rem}figcaption{font-weight:600}";

}  // namespace

void write_plots(const std::string& file, const std::string& title, const std::vector<report::Plot>& plots) {
    std::ofstream out(file);
    out << "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>" << title << "</title><style>"
        << page_css << report::plot_css() << "</style></head>\n<body><h1>" << title << "</h1>\n";
    for (const report::Plot& plot : plots) out << report::to_figure(plot) << '\n';
    out << "</body></html>\n";
    if (!out) throw std::runtime_error("cannot write " + file);
}

}  // namespace lodestream::bench
