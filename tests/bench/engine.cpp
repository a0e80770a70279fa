#include "tests/bench/engine.h"

#include <stdexcept>
#include <utility>

#include "server/bake/executor.h"
#include "tests/bench/methods.h"

namespace lodestream::bench {

Recording record(mesh::Mesh mesh) {
    simplify::RecordOptions options;
    options.executor = bake::all_cores();
    Result<simplify::History> history = simplify::record_history(std::move(mesh), options);
    if (!history) throw std::runtime_error(history.error().message);
    return {std::move(*history)};
}

mesh::Mesh cut(const Recording& recording, std::uint64_t triangles) {
    return simplify::cut(recording.history, triangles);
}

Run run_ours(const mesh::Mesh& mesh, const std::vector<std::uint64_t>& counts) {
    Run run;
    mesh::Mesh own = mesh;
    const Stopwatch recording_time;
    const Recording recording = record(std::move(own));
    const Duration recorded = recording_time.elapsed();
    const Stopwatch cut_time;
    for (const std::uint64_t count : counts) run.levels.push_back({cut(recording, count), recorded});
    run.cut = cut_time.elapsed();
    return run;
}

}  // namespace lodestream::bench
