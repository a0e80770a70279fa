#include "server/cli/asset_folder.h"

#include <algorithm>
#include <condition_variable>
#include <cstdio>
#include <mutex>
#include <vector>

#include "server/bake/bake.h"
#include "server/cli/commands.h"
#include "server/importer/importer.h"

namespace lodestream::cli {

namespace fs = std::filesystem;

namespace {

// Beside an asset's baked model: the state of the file that it was made of, so that a restart does not bake it again.
constexpr std::string_view source_key = "source";

std::string stamp_of(const fs::directory_entry& entry) {
    std::error_code ignored;
    const auto time = entry.last_write_time(ignored).time_since_epoch().count();
    return std::to_string(entry.file_size(ignored)) + " " + std::to_string(time);
}

std::vector<fs::directory_entry> model_files(const fs::path& folder) {
    std::vector<fs::directory_entry> files;
    std::error_code error;
    for (fs::recursive_directory_iterator it(folder, fs::directory_options::skip_permission_denied, error), end;
         !error && it != end && files.size() < AssetFolder::max_files; it.increment(error))
        if (it->is_regular_file(error) && importer::format_of_extension(it->path())) files.push_back(*it);
    std::sort(files.begin(), files.end());
    return files;
}

}  // namespace

AssetFolder::AssetFolder(fs::path folder, store::Store& store, http::BakeQueue& bakes)
    : folder_(std::move(folder)), store_(store), bakes_(bakes), thread_([this](const std::stop_token& stop) {
          std::mutex mutex;
          std::condition_variable_any wake;
          std::unique_lock lock(mutex);
          while (!stop.stop_requested()) {
              scan();
              wake.wait_for(lock, stop, interval, [] { return false; });
          }
      }) {}

AssetFolder::~AssetFolder() = default;

void AssetFolder::scan() {
    for (const fs::directory_entry& entry : model_files(folder_)) {
        const std::string stamp = stamp_of(entry);
        std::string& seen = seen_[entry.path()];
        if (seen == stamp) continue;
        seen = stamp;
        submit(entry.path(), stamp);
    }
}

void AssetFolder::submit(const fs::path& file, const std::string& stamp) {
    const std::string name = asset_name_of(file.string());
    const std::string source = fs::absolute(file).string() + " " + stamp;
    if (Result<proto::Asset> known = store_.asset(name)) {
        const Result<store::Store::Content> baked_of = store_.content(known->id, source_key);
        if (known->status == proto::AssetStatus::ready && baked_of && baked_of->record == source) return;
        bakes_.cancel(known->id);
        (void)store_.remove_asset(known->id);
    }
    Result<proto::Asset> asset = bakes_.submit(name, file);
    if (!asset) {
        std::fprintf(stderr, "%s: %s\n", file.c_str(), asset.error().message.c_str());
        return;
    }
    (void)store_.put_content(asset->id, source_key, "txt", std::as_bytes(std::span(source)), source);
}

}  // namespace lodestream::cli
