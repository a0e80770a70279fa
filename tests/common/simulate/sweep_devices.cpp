// The sweep of many simulated devices over the twenty motions, as a table: sweep_devices [DEVICES [SECONDS]].
// Exits with 1 where `predictive` keeps the deadline less often than another controller on any motion.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <future>
#include <thread>
#include <vector>

#include "common/simulate/sweep.h"

namespace {

using namespace lodestream;

using Sweep = std::vector<std::array<simulate::PerController, simulate::trace_count>>;

Sweep run(const std::array<simulate::NamedTrace, simulate::trace_count>& traces, std::uint64_t devices) {
    const std::uint64_t parts = std::max(1u, std::thread::hardware_concurrency());
    std::vector<std::future<Result<Sweep>>> running;
    for (std::uint64_t part = 0; part < parts; ++part) {
        const std::uint64_t begin = devices * part / parts, end = devices * (part + 1) / parts;
        running.push_back(std::async(std::launch::async, [&traces, begin, end] {
            return simulate::sweep(simulate::SweepOptions{}, traces, begin, end - begin);
        }));
    }
    Sweep all;
    for (auto& part : running) {
        const Result<Sweep> done = part.get();
        if (!done) {
            std::fprintf(stderr, "sweep_devices: %s\n", done.error().message.c_str());
            std::exit(1);
        }
        all.insert(all.end(), done->begin(), done->end());
    }
    return all;
}

// One line a motion and controller; true where no other controller kept the deadline more often than `predictive`.
bool print(const Sweep& sweep, std::size_t trace, const std::string& name) {
    std::array<double, std::size(control::kinds)> kept{};
    for (std::size_t kind = 0; kind < kept.size(); ++kind) {
        double worst = 1.0, deviation = 0.0, switches = 0.0, error_px = 0.0;
        const double count = static_cast<double>(sweep.size());
        for (const auto& device : sweep) {
            const control::FlightSummary& flown = device[trace][kind];
            kept[kind] += flown.within_deadline / count;
            worst = std::min(worst, flown.within_deadline);
            deviation += flown.deviation_fps / count;
            switches += flown.switches / count;
            error_px += flown.mean_error_px / count;
        }
        std::printf(
            "%-18s %-12s within %7.3f %%  worst device %7.3f %%  sigma %6.2f fps  switches %7.2f  error %.3f px\n",
            name.c_str(), control::kind_name(control::kinds[kind]), 100.0 * kept[kind], 100.0 * worst, deviation,
            switches, error_px);
    }
    return *std::max_element(kept.begin(), kept.end()) == kept.back();
}

}  // namespace

int main(int argc, char** argv) {
    const long devices = argc > 1 ? std::strtol(argv[1], nullptr, 10) : 1000;
    const double seconds = argc > 2 ? std::strtod(argv[2], nullptr) : 8.0;
    if (devices < 1 || devices > 1'000'000 || !(seconds >= 1.0 && seconds <= 600.0)) {
        std::fprintf(stderr, "usage: sweep_devices [DEVICES, 1 to 1000000 [SECONDS, 1 to 600]]\n");
        return 2;
    }
    const auto traces = simulate::sweep_traces(seconds);
    const Sweep sweep = run(traces, static_cast<std::uint64_t>(devices));
    bool ahead = true;
    for (std::size_t trace = 0; trace < traces.size(); ++trace)
        ahead = print(sweep, trace, traces[trace].name) && ahead;
    std::printf("%ld devices: predictive keeps the deadline at least as often as every other on every motion: %s\n",
                devices, ahead ? "yes" : "NO");
    return ahead ? 0 : 1;
}
