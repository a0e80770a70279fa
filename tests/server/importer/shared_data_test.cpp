// Sweeps over the real meshes: models import to what their manifest counts, malformed files are refused or sane.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "server/importer/importer.h"
#include "tests/server/importer/sane.h"
#include "tests/support/meshes.h"

namespace lodestream::importer {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> models_below(const fs::path& folder) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::recursive_directory_iterator(folder))
        if (entry.is_regular_file() && format_of_extension(entry.path())) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    return files;
}

Result<mesh::Model> import_and_report(const fs::path& file, const fs::path& root) {
    const auto start = std::chrono::steady_clock::now();
    Result<mesh::Model> model = import_file(file);
    const std::chrono::duration<double, std::milli> spent = std::chrono::steady_clock::now() - start;
    std::printf("%-58s %7.1f ms  ", file.lexically_relative(root).c_str(), spent.count());
    if (!model) {
        std::printf("refused: %s\n", model.error().message.c_str());
        return model;
    }
    std::printf("%8zu t %8zu v  %s %u", model->mesh.triangles.size(), model->mesh.positions.size(),
                mesh::kind_name(model->kind), model->objects);
    for (const std::string& warning : model.warnings) std::printf("; %s", warning.c_str());
    std::printf("\n");
    return model;
}

TEST(SharedData, EveryModelImportsToSaneGeometry) {
    LODESTREAM_NEED_SHARED_DATA();
    const fs::path root = testing::shared_data();
    // Valid files without one triangle to show, and images that are textures or colour-coded heights.
    const std::vector<std::string> refused = {"gltf/empty_nodes.glb", "hard/degenerate_mesh.obj"};
    for (const char* folder : {"classic", "scan", "scene", "terrain", "gltf", "hard"})
        for (const fs::path& file : models_below(root / folder)) {
            if (file.extension() == ".png") continue;
            const Result<mesh::Model> model = import_and_report(file, root);
            const std::string name = file.lexically_relative(root).string();
            const bool expected = std::find(refused.begin(), refused.end(), name) == refused.end();
            EXPECT_EQ(model.ok(), expected) << name;
            if (model) testing::expect_sane(*model, name);
        }
}

TEST(SharedData, EveryMalformedFileIsRefusedOrSane) {
    LODESTREAM_NEED_SHARED_DATA();
    const fs::path root = testing::shared_data();
    for (const fs::path& file : models_below(root / "malformed")) {
        const Result<mesh::Model> model = import_and_report(file, root);
        if (model) {
            testing::expect_sane(*model, file.string());
            continue;
        }
        EXPECT_FALSE(model.error().message.empty()) << file;
        EXPECT_EQ(model.error().message.find('\n'), std::string::npos) << file;
    }
}

// Triangles as the collection's manifest counts them, with degenerate ones gone where it says so.
TEST(SharedData, KnownModelsHaveTheirKnownTriangleCounts) {
    LODESTREAM_NEED_SHARED_DATA();
    const std::map<std::string, std::size_t> known = {
        {"classic/bunny_69k.ply", 69451},
        {"classic/bunny_69k.stl", 69451},
        {"classic/bunny_7k.off", 6966},
        {"classic/horse_97k_bigendian.ply", 96966},
        {"classic/nefertiti_100k.obj", 99938},
        {"scene/delft_city_georef.obj", 36271},
        {"gltf/bunny_gltf.drc", 69451},
        {"gltf/Duck.glb", 4212},
        {"gltf/pins_instances.glb", 3408},
        {"gltf/SimpleSparseAccessor/SimpleSparseAccessor.gltf", 12},
        {"gltf/PrimitiveMode/Mesh_PrimitiveMode_04.gltf", 2},
        {"gltf/PrimitiveMode/Mesh_PrimitiveMode_05.gltf", 2},
        {"gltf/PrimitiveMode/Mesh_PrimitiveMode_06.gltf", 2},
        {"hard/stl_CR_only.stl", 12},
        {"terrain/stubai_10m.asc", 231914},
    };
    for (const auto& [name, triangles] : known) {
        const Result<mesh::Model> model = import_file(testing::shared_data() / name);
        ASSERT_TRUE(model.ok()) << name << ": " << model.error().message;
        EXPECT_EQ(model->mesh.triangles.size(), triangles) << name;
    }
}

// What moves is taken as it rests, and the model says so.
TEST(SharedData, SkinnedMorphedAndAnimatedModelsWarnOfTheirRestPose) {
    LODESTREAM_NEED_SHARED_DATA();
    const fs::path gltf = testing::shared_data() / "gltf";
    const auto warning = [](const fs::path& file, const std::string& what) {
        const Result<mesh::Model> model = import_file(file);
        if (!model) return model.error().message;
        for (const std::string& line : model.warnings)
            if (line.find(what) != std::string::npos && line.find("rest pose") != std::string::npos)
                return std::string("warned");
        return "no warning of " + what;
    };
    for (const fs::path& file : {gltf / "CesiumMan.glb", gltf / "Fox" / "Fox.gltf"})
        for (const char* what : {"skins", "animations"}) EXPECT_EQ(warning(file, what), "warned") << file;
    for (const char* what : {"morph targets", "animations"})
        EXPECT_EQ(warning(gltf / "MorphStressTest" / "MorphStressTest.gltf", what), "warned");
}

}  // namespace
}  // namespace lodestream::importer
