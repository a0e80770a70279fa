// The commands of `lodestream-server`, one function each. They print their results on stdout and return what failed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "server/bake/limits.h"

namespace lodestream::cli {

struct ServeArguments {
    std::string listen = "127.0.0.1:8080";
    std::filesystem::path store;
    std::optional<std::filesystem::path> assets;  // folder, imported at start and watched
    bool samples = false;                         // bake the built-in samples at start
    unsigned threads = 0;                         // 0: one a core
    std::optional<std::filesystem::path> token_file;
    bake::Limits limits;
};
Status serve(const ServeArguments& arguments);

struct BakeArguments {
    std::vector<std::string> inputs;  // files, or "sample:NAME[:COUNT]"
    std::filesystem::path store;
    bool json = false;
    bool resume = false;  // first go on with the bakes that an end of the program left
    bake::Limits limits;
};
// Ctrl-C cancels: the running bake's asset becomes `failed`, further inputs are left out.
Status bake(const BakeArguments& arguments);

struct CutArguments {
    std::filesystem::path store;
    std::string asset;
    std::uint64_t triangles = 0;
    std::optional<std::uint64_t> points;  // the point level of at most so many instead
    std::filesystem::path out;            // .glb or .ply
    bool json = false;
};
Status cut(const CutArguments& arguments);

struct TilesetArguments {
    std::filesystem::path store;
    std::string asset;
    std::filesystem::path out;  // a folder, or one file that ends in .3tz
};
Status tileset(const TilesetArguments& arguments);

struct SampleArguments {
    std::string sample;         // "teapot", "terrain:40000", …
    std::filesystem::path out;  // .glb or .ply
};
Status sample(const SampleArguments& arguments);

// Reads "sample:NAME[:COUNT]" or a model file. The name of the asset is the sample's, or the file's without its
// extension.
inline constexpr const char* sample_prefix = "sample:";
inline constexpr const char* served_samples[] = {"sample:teapot", "sample:terrain:40000", "sample:ship"};
std::string asset_name_of(const std::string& input);

}  // namespace lodestream::cli
