#include "tests/bench/scenes_json.h"

#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "tests/bench/provenance_json.h"

namespace lodestream::bench {

void write_scene_run(const std::string& file, const std::string& command_line, const proto::SceneRun& run) {
    nlohmann::json bakes = nlohmann::json::array();
    for (const proto::SceneBake& bake : run.bakes)
        bakes.push_back({{"objects", bake.objects},
                         {"triangles", bake.triangles},
                         {"tiles", bake.tiles},
                         {"bytes", bake.bytes},
                         {"wall_ms", bake.wall_ms},
                         {"cpu_ms", bake.cpu_ms},
                         {"tiles_ms", bake.tiles_ms},
                         {"peak_memory_bytes", bake.peak_memory_bytes}});
    const nlohmann::json scene{{"model", run.bakes.front().scene}, {"bakes", std::move(bakes)}};
    std::ofstream out(file);
    out << nlohmann::json{{"run", provenance_json(command_line)}, {"models", {scene}}}.dump(2) << '\n';
    if (!out.flush()) throw std::runtime_error("cannot write " + file);
}

}  // namespace lodestream::bench
