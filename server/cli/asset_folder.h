// Keeps the assets of a folder baked: every model in it at start, and what is added or changed later. A removed file's
// asset stays.
#pragma once

#include <chrono>
#include <filesystem>
#include <map>
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

    void scan();  // once; the thread calls it every `interval`

  private:
    void submit(const std::filesystem::path& file, const std::string& stamp);

    std::filesystem::path folder_;
    store::Store& store_;
    http::BakeQueue& bakes_;
    std::map<std::filesystem::path, std::string> seen_;  // file: size and time of what was submitted
    std::jthread thread_;
};

}  // namespace lodestream::cli
