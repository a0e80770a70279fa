// lodestream_bench_scene: the cut of a large tree along a moving camera; see README.md.
#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "common/scene/select.h"
#include "tests/bench/stopwatch.h"
#include "tests/common/scene/trees.h"

namespace lodestream::bench {
namespace {

constexpr std::size_t node_count = 100'000;
constexpr int frames = 2'000;
constexpr double median_target_ms = 1.0;

// Flies through the scene along its longest axis, looking a little to the side.
scene::View view_at(const Box& box, double t) {
    scene::View view;
    view.eye = box.min + box.extent() * Vec3d{1.2 * t - 0.1, 0.5 + 0.3 * std::sin(9.0 * t), 0.5};
    view.target = view.eye + Vec3d{1.0, 0.1, std::sin(5.0 * t)};
    view.width = 1'920;
    view.height = 1'080;
    view.near = 1e-3 * box.diagonal();
    return view;
}

void fly(const scene::LodTree& tree, scene::SelectOptions options, const char* mode, bool from_root) {
    std::vector<double> wall_ms, cpu_ms;
    std::size_t nodes = 0;
    for (int frame = 0; frame < frames; ++frame) {
        const Stopwatch time;
        const scene::Selection selection = select(tree, view_at(tree[0].box, 1.0 * frame / frames), options);
        const Duration took = time.elapsed();
        wall_ms.push_back(took.wall_ms);
        cpu_ms.push_back(took.cpu_ms);
        nodes += selection.nodes.size();
        if (!from_root) options.start_px = selection.threshold_px;
    }
    for (std::vector<double>* times : {&wall_ms, &cpu_ms}) std::sort(times->begin(), times->end());
    std::printf("%-34s %10.0f %10.4f %10.4f %10.4f %10s\n", mode, static_cast<double>(nodes) / frames,
                wall_ms[frames / 2], wall_ms[frames * 99 / 100], cpu_ms[frames / 2],
                wall_ms[frames / 2] < median_target_ms ? "held" : "missed");
}

void run() {
    Random random(1);
    const scene::LodTree tree = scene::testing::made_tree(node_count, random);
    std::printf("%zu nodes, %d frames, target: median below %.0f ms\n", tree.size(), frames, median_target_ms);
    std::printf("%-34s %10s %10s %10s %10s %10s\n", "mode", "nodes", "median ms", "p99 ms", "CPU ms", "target");
    for (const double tolerance_px : {8.0, 2.0, 1.0}) {
        scene::SelectOptions options;
        options.tolerance_px = tolerance_px;
        fly(tree, options, ("quality, " + std::to_string(static_cast<int>(tolerance_px)) + " px").c_str(), false);
    }
    for (const std::uint64_t budget : {100'000u, 1'000'000u, 5'000'000u}) {
        scene::SelectOptions options;
        options.budget = budget;
        const std::string mode = "budget, " + std::to_string(budget);
        fly(tree, options, (mode + ", last frame's cut").c_str(), false);
        fly(tree, options, (mode + ", from the root").c_str(), true);
    }
}

}  // namespace
}  // namespace lodestream::bench

int main() {
    lodestream::bench::run();
    return 0;
}
