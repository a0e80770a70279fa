#include "client/report/report.h"

#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <thread>

#include "client/render/gl_context.h"
#include "client/report/benchmarks.h"
#include "client/report/document.h"
#include "client/report/gather.h"
#include "client/report/machine.h"
#include "client/report/sections.h"
#include "client/report/server_process.h"
#include "client/report/text.h"

namespace lodestream::report {
namespace {

Provenance provenance(const ReportOptions& options, const render::GlContext& context) {
    Provenance from = provenance_of(options.command_line);
    from.renderer = context.renderer();
    from.software_renderer = context.software();
    from.quick = options.quick;
    return from;
}

// One line on a terminal's stderr, replaced with every step; nothing elsewhere.
class ProgressLine {
  public:
    void show(const std::string& what) const {
        if (!on_) return;
        const auto seconds =
            std::chrono::duration_cast<std::chrono::seconds>(std::chrono::steady_clock::now() - start_);
        std::fprintf(stderr, "\r\033[K[%3lld s] %s", static_cast<long long>(seconds.count()), printable(what).c_str());
    }
    void clear() const {
        if (on_) std::fputs("\r\033[K", stderr);
    }

  private:
    bool on_ = isatty(STDERR_FILENO) != 0;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

// While it lives, the first SIGINT and the first SIGTERM ask for an orderly end, so that a server of our own and its
// temporary store do not stay behind; a second one ends the program at once.
class Interrupts {
  public:
    Interrupts() {
        was_asked = 0;
        struct sigaction action {};
        action.sa_handler = [](int) { was_asked = 1; };
        action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
        sigaction(SIGINT, &action, &old_int_);
        sigaction(SIGTERM, &action, &old_term_);
    }
    ~Interrupts() {
        sigaction(SIGINT, &old_int_, nullptr);
        sigaction(SIGTERM, &old_term_, nullptr);
    }
    Interrupts(const Interrupts&) = delete;
    Interrupts& operator=(const Interrupts&) = delete;

    static bool asked() { return was_asked != 0; }

  private:
    static inline volatile std::sig_atomic_t was_asked = 0;
    struct sigaction old_int_ {};
    struct sigaction old_term_ {};
};

Status write_text(const std::filesystem::path& path, const std::string& text) {
    std::ofstream file(path, std::ios::binary | std::ios::trunc);
    file << text << std::flush;
    if (!file) return fail(ErrorCode::io, "cannot write " + path.string());
    return Nothing{};
}

Status make_folders(const std::filesystem::path& out) {
    std::error_code error;
    std::filesystem::create_directories(out / "pictures", error);
    if (error)
        return fail(ErrorCode::io, "cannot make the folder " + (out / "pictures").string() + ": " + error.message());
    return Nothing{};
}

Result<ReportData> measure(const ReportOptions& options, const std::string& url) {
    Result<render::GlContext> context = render::create_headless_context();
    if (!context) return context.error();
    Result<render::Renderer> renderer = render::Renderer::create();
    if (!renderer) return renderer.error();
    Result<sdk::Client> client = sdk::Client::open(url);
    if (!client) return client.error();

    const ProgressLine progress;
    Result<ReportData> data =
        gather(*client, *renderer, {options.out, url, options.quick, [&](const std::string& step) {
                                        progress.show(step);
                                        return !Interrupts::asked();
                                    }});
    progress.clear();
    if (data) data->provenance = provenance(options, *context);
    return data;
}

void print(const ReportData& data, const ReportOptions& options, const std::string& json) {
    if (options.json) {
        std::cout << json << std::flush;
        return;
    }
    std::cout << to_text(overview_table(data), isatty(STDOUT_FILENO) != 0);
    for (const std::string& problem : data.problems) std::cout << "not in this report: " << printable(problem) << "\n";
    std::cout << "report: " << (options.out / "report.html").string() << std::endl;
}

template <class Run>
Status read_if_given(const std::optional<std::filesystem::path>& file,
                     Result<Run> (*read)(const std::filesystem::path&), std::optional<Run>& run) {
    if (!file) return Nothing{};
    Result<Run> found = read(*file);
    if (!found) return found.error();
    run = *std::move(found);
    return Nothing{};
}

}  // namespace

Status run(const ReportOptions& options) {
    if (Status made = make_folders(options.out); !made) return made;
    std::optional<proto::MethodRun> methods;
    std::optional<proto::CodecRun> codecs;
    std::optional<proto::PointsRun> points;
    std::optional<proto::SceneRun> scenes;
    if (Status read = read_if_given(options.methods, read_methods, methods); !read) return read;
    if (Status read = read_if_given(options.codecs, read_codecs, codecs); !read) return read;
    if (Status read = read_if_given(options.points, read_points, points); !read) return read;
    if (Status read = read_if_given(options.scenes, read_scenes, scenes); !read) return read;
    const Interrupts interrupts;
    std::optional<ServerProcess> server;
    if (options.server_url.empty()) {
        Result<ServerProcess> started = ServerProcess::start(server_beside_this_program(), options.assets);
        if (!started) return started.error();
        server.emplace(std::move(*started));
    }
    Result<ReportData> data = measure(options, server ? server->url() : options.server_url);
    if (!data) return data.error();
    data->methods = std::move(methods);
    data->codecs = std::move(codecs);
    data->points = std::move(points);
    data->scenes = std::move(scenes);

    const std::string json = json_document(*data);
    if (Status written = write_text(options.out / "report.html", html_document(*data)); !written) return written;
    if (Status written = write_text(options.out / "report.json", json); !written) return written;
    print(*data, options, json);
    return Nothing{};
}

}  // namespace lodestream::report
