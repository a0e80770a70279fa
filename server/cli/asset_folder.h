// Keeps the assets of a folder and its sub-folders baked: every model in it at start, and what is added or changed
// later. A removed file's asset stays.
// An asset is named after its file without the extension. Where another file, an upload or a sample has that name
// already, it keeps its extension; where that is taken too, its path in the folder with '-' for '/', then numbered.
#pragma once

#include <chrono>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <thread>

#include "server/http/bake_queue.h"
#include "server/store/store.h"

namespace lodestream::cli {

class AssetFolder {
  public:
    static constexpr std::chrono::milliseconds interval{2'000};
    static constexpr std::size_t max_files = 10'000;

    // Starts watching on a thread of its own until destroyed.
    AssetFolder(std::filesystem::path folder, store::Store& store, http::BakeQueue& bakes);
    ~AssetFolder();

    void scan();  // once; the thread calls it every `interval`. The first says on stderr what it found.

  private:
    struct Outcome {
        std::size_t models = 0;
        std::size_t refused = 0;
    };
    Outcome submit_changed();
    std::optional<std::string> name_of(const std::filesystem::path& file);
    bool is_free(const std::string& name) const;
    bool submit(const std::filesystem::path& file, const std::string& stamp);  // false: refused

    std::filesystem::path folder_;
    store::Store& store_;
    http::BakeQueue& bakes_;
    std::map<std::filesystem::path, std::string> seen_;   // file: size and time of what was submitted
    std::map<std::filesystem::path, std::string> names_;  // file: its asset's name
    std::set<std::string> ids_;                           // of those names
    bool first_scan_ = true;
    std::jthread thread_;
};

}  // namespace lodestream::cli
