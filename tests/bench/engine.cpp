#include "tests/bench/engine.h"

#include <stdexcept>
#include <utility>

#include "server/bake/executor.h"
#include "tests/bench/copied_process.h"
#include "tests/bench/inputs.h"
#include "tests/bench/methods.h"
#include "tests/bench/process_memory.h"

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

std::uint64_t recording_peak_bytes(const std::string& spec, const std::string& folder) {
    mesh::Mesh mesh;
    const auto load = [&] {
        run_in_copy(
            [&](std::FILE* out) {
                const Result<Input> input = load_input(spec, folder);
                if (!input) throw std::runtime_error(input.error().message);
                send(input->mesh.positions, out);
                send(input->mesh.normals, out);
                send(input->mesh.triangles, out);
            },
            [&](std::FILE* in) {
                mesh.positions = receive<Vec3f>(in);
                mesh.normals = receive<Vec3f>(in);
                mesh.triangles = receive<mesh::Triangle>(in);
            });
    };
    return peak_growth_bytes([&] { record(std::move(mesh)); }, load);
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
