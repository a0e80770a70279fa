// Objects of a served scene move all the time, 100 a second unless told otherwise, each another one: how long until a
// waiting client has each at its place, what the finest tiles are off meanwhile, whether anything leaks, and whether
// all is as it should be in the end. Fails where it is not. Real processes, real sockets.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "client/sdk/client.h"
#include "common/base/random.h"
#include "common/base/transform.h"
#include "tests/support/program.h"

namespace {

using namespace lodestream;
using Clock = std::chrono::steady_clock;
namespace fs = std::filesystem;

constexpr double batches_per_second = 10.0;
constexpr double stride_m = 3.0;                         // that an object is moved by, at most
constexpr double most_settling_s = 600.0;                // until all tiles are whole again
constexpr double most_sweeping_s = 300.0;                // and until what was made before is gone
constexpr std::uint64_t first_id_of_parts = 1ull << 32;  // of tiles that the bake has not made
constexpr double largest_growth = 1.25;                  // of memory, from the half of the run to its end
constexpr double stated_staleness_s = 2.0;               // the bound that is claimed for 100 a second

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

double resident_mb(pid_t pid) {
    std::ifstream in("/proc/" + std::to_string(pid) + "/status");
    for (std::string word; in >> word;)
        if (word == "VmRSS:") {
            double kilobytes = 0.0;
            in >> kilobytes;
            return kilobytes / 1024.0;
        }
    return 0.0;
}

std::size_t files_below(const fs::path& folder) {
    std::size_t files = 0;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) files += entry.is_regular_file() ? 1 : 0;
    return files;
}

// What was asked for, until a client has it.
struct Pending {
    Mat4d matrix;
    Clock::time_point answered;
    std::uint64_t revision = 0;
};

struct Run {
    std::mutex mutex;
    std::map<std::uint32_t, Pending> pending;  // of each node
    std::vector<double> staleness_s;
    double worst_finest_error = 0.0;
    std::uint64_t tilesets = 0, changes = 0;
    std::uint64_t superseded = 0;  // moved again before a client had it
    std::string failure;
    std::atomic<bool> is_over{false};

    void fail(const std::string& what) {
        const std::lock_guard lock(mutex);
        if (failure.empty()) failure = what;
        is_over = true;
    }
};

void note(Run& run, const proto::Tileset& tileset) {
    const Clock::time_point now = Clock::now();
    std::map<std::uint32_t, std::size_t> tiles;
    double finest_error = 0.0;
    for (std::size_t i = 0; i < tileset.nodes.size(); ++i) {
        if (tileset.nodes[i].child_count == 0) finest_error = std::max(finest_error, tileset.nodes[i].error);
        tiles[tileset.scene_nodes[i]] = i;
    }
    const std::lock_guard lock(run.mutex);
    ++run.tilesets;
    run.worst_finest_error = std::max(run.worst_finest_error, finest_error);
    std::erase_if(run.pending, [&](const auto& entry) {
        const auto& [node, pending] = entry;
        if (tileset.revision < pending.revision) return false;
        const auto tile = tiles.find(node);
        // Its own tile, or whole again with its neighbours, which are true.
        const bool is_there = tile != tiles.end() ? distance(tileset.matrix(tile->second)[3], pending.matrix[3]) < 1e-9
                                                  : finest_error == 0.0;
        if (is_there) run.staleness_s.push_back(std::chrono::duration<double>(now - pending.answered).count());
        return is_there;
    });
}

void watch(Run& run, const std::string& url, const std::string& asset) {
    auto client = sdk::Client::open(url);
    if (!client) return run.fail(client.error().message);
    std::uint64_t revision = 0;
    while (!run.is_over) {
        auto newer = client->newer_tileset(asset, revision);
        if (!newer) return run.fail(newer.error().message);
        if (!*newer) continue;
        revision = (*newer)->revision;
        if (Status added = client->add_documents(**newer); !added) return run.fail(added.error().message);
        note(run, **newer);
    }
}

void move(Run& run, const std::string& url, const std::string& asset, std::uint32_t nodes, double rate,
          double seconds) {
    auto client = sdk::Client::open(url);
    if (!client) return run.fail(client.error().message);
    Random random{17};
    const Clock::time_point start = Clock::now();
    for (int batch = 0; batch < seconds * batches_per_second && !run.is_over; ++batch) {
        std::this_thread::sleep_until(start + std::chrono::duration_cast<Clock::duration>(
                                                  std::chrono::duration<double>(batch / batches_per_second)));
        std::map<std::uint32_t, proto::NodeChange> changes;
        while (changes.size() < static_cast<std::size_t>(rate / batches_per_second)) {
            const auto node = static_cast<std::uint32_t>(1.0 + random.uniform() * (nodes - 1.0));
            const auto part = [&] { return stride_m * (2.0 * random.uniform() - 1.0); };
            changes[node] = {node, matrix_of({part(), part(), part()}, {0, 0, 0, 1}, {1, 1, 1}), std::nullopt};
        }
        std::vector<proto::NodeChange> list;
        for (const auto& [node, change] : changes) list.push_back(change);
        const auto changed = client->change_nodes(asset, list);
        if (!changed) return run.fail(changed.error().message);
        const std::lock_guard lock(run.mutex);
        for (const proto::NodeChange& change : list) {
            const auto [entry, is_new] =
                run.pending.insert_or_assign(change.node, Pending{*change.matrix, Clock::now(), changed->revision});
            run.superseded += is_new ? 0 : 1;
        }
        run.changes += list.size();
    }
}

// Whether every object is one with its neighbours, and drawn at its place.
bool is_whole(const proto::Tileset& tileset) {
    for (std::size_t i = 0; i < tileset.nodes.size(); ++i) {
        const bool is_own = tileset.ids[i] >= first_id_of_parts;
        if (is_own || (tileset.nodes[i].child_count == 0 && tileset.nodes[i].error > 0.0)) return false;
    }
    return true;
}

double quantile(std::vector<double> values, double share) {
    if (values.empty()) return 0.0;
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

struct Arguments {
    std::string server, store, asset = "ship";
    double rate = 100.0, seconds = 60.0;
};

int bench(const Arguments& arguments) {
    const testing::ServerProgram server(arguments.server, arguments.store);
    auto client = sdk::Client::open(server.url);
    if (!client) throw std::runtime_error(client.error().message);
    const auto nodes = client->nodes(arguments.asset);
    if (!nodes) throw std::runtime_error(nodes.error().message);
    const auto before = client->tileset(arguments.asset);
    if (!before) throw std::runtime_error(before.error().message);

    Run run;
    const fs::path content = fs::path(arguments.store) / "content";
    const std::size_t files_before = files_below(content);
    std::thread watcher([&] { watch(run, server.url, arguments.asset); });
    std::thread mover([&] {
        move(run, server.url, arguments.asset, static_cast<std::uint32_t>(nodes->count), arguments.rate,
             arguments.seconds);
    });
    const Clock::time_point start = Clock::now();
    std::vector<double> memory_mb;
    while (seconds_since(start) < arguments.seconds && !run.is_over) {
        std::this_thread::sleep_for(std::chrono::seconds(1));
        memory_mb.push_back(resident_mb(server.pid()));
    }
    mover.join();
    const std::size_t files_most = files_below(content);
    const Clock::time_point moved = Clock::now();
    auto after = client->tileset(arguments.asset);
    while (after && !is_whole(*after) && seconds_since(moved) < most_settling_s && !run.is_over) {
        std::this_thread::sleep_for(std::chrono::milliseconds(500));
        after = client->tileset(arguments.asset);
    }
    if (!after) throw std::runtime_error(after.error().message);
    const double settling_s = seconds_since(moved);
    const std::size_t files_allowed = files_before + after->nodes.size();
    std::size_t files_after = files_below(content);
    for (const Clock::time_point whole = Clock::now();
         files_after > files_allowed && seconds_since(whole) < most_sweeping_s; files_after = files_below(content))
        std::this_thread::sleep_for(std::chrono::seconds(1));
    const double memory_after = resident_mb(server.pid());
    // A last change ends the watcher's wait.
    static_cast<void>(client->change_nodes(arguments.asset, {{0, std::nullopt, true}}));
    run.is_over = true;
    watcher.join();

    const double half_mb = memory_mb.empty() ? 0.0 : memory_mb[memory_mb.size() / 2];
    const double most_mb = memory_mb.empty() ? 0.0 : *std::max_element(memory_mb.begin(), memory_mb.end());
    const double worst = quantile(run.staleness_s, 1.0);
    std::printf(
        "{\"objects\":%llu,\"tiles\":%zu,\"changes\":%llu,\"superseded\":%llu,\"tilesets\":%llu,\"staleness_s\":{"
        "\"p50\":%.4f,\"p99\":%.4f,\"max\":%.4f,\"pending\":%zu},\"finest_error_max\":%.4f,\"root_error\":{\"before\":"
        "%.4f,\"after\":%.4f},\"memory_mb\":{\"half\":%.1f,\"most\":%.1f,\"after\":%.1f},\"files\":{\"before\":%zu,"
        "\"most\":%zu,\"after\":%zu},\"settling_s\":%.1f}\n",
        static_cast<unsigned long long>(nodes->count - 1), before->nodes.size(),
        static_cast<unsigned long long>(run.changes), static_cast<unsigned long long>(run.superseded),
        static_cast<unsigned long long>(run.tilesets), quantile(run.staleness_s, 0.5), quantile(run.staleness_s, 0.99),
        worst, run.pending.size(), run.worst_finest_error, before->nodes[0].error, after->nodes[0].error, half_mb,
        most_mb, memory_after, files_before, files_most, files_after, settling_s);
    std::vector<std::string> wrong;
    if (!run.failure.empty()) wrong.push_back(run.failure);
    if (!run.pending.empty()) wrong.push_back("some change never came");
    if (worst > stated_staleness_s) wrong.push_back("a change came later than is claimed");
    if (!is_whole(*after)) wrong.push_back("its tiles are not whole again");
    if (files_after > files_allowed) wrong.push_back("files were left behind");
    if (most_mb > largest_growth * half_mb) wrong.push_back("memory grew all the time");
    for (const std::string& what : wrong) std::fprintf(stderr, "bench_moving: %s\n", what.c_str());
    return wrong.empty() ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
    Arguments arguments;
    CLI::App app{"Moves objects of a served scene and measures how stale its tiles ever are."};
    app.add_option("--server", arguments.server, "The lodestream-server program")->required();
    app.add_option("--store", arguments.store, "A store with a baked scene; it is changed")->required();
    app.add_option("--asset", arguments.asset, "The scene")->capture_default_str();
    app.add_option("--rate", arguments.rate, "Objects a second")->check(CLI::Range(10.0, 100'000.0));
    app.add_option("--seconds", arguments.seconds, "For so long")->check(CLI::PositiveNumber);
    CLI11_PARSE(app, argc, argv);
    try {
        return bench(arguments);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "bench_moving: %s\n", error.what());
        return 1;
    }
}
