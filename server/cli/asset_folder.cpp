#include "server/cli/asset_folder.h"

#include <algorithm>
#include <condition_variable>
#include <cstdio>
#include <mutex>
#include <utility>
#include <vector>

#include "server/bake/bake.h"
#include "server/cli/commands.h"
#include "server/importer/importer.h"

namespace lodestream::cli {

namespace fs = std::filesystem;

namespace {

// Beside an asset's baked model: the state of the file that it was made of, so that a restart does not bake it again.
constexpr std::string_view source_key = http::BakeQueue::origin_key;
constexpr std::size_t max_namesakes = 16;  // files whose names and paths differ in nothing that an asset's id keeps

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
    const Outcome outcome = submit_changed();
    if (!std::exchange(first_scan_, false)) return;
    std::fprintf(stderr, "assets: %zu models found, %zu refused\n", outcome.models, outcome.refused);
}

AssetFolder::Outcome AssetFolder::submit_changed() {
    Outcome outcome;
    for (const fs::directory_entry& entry : model_files(folder_)) {
        const std::string stamp = stamp_of(entry);
        std::string& seen = seen_[entry.path()];
        ++outcome.models;
        if (seen == stamp) continue;
        seen = stamp;
        if (!submit(entry.path(), stamp)) ++outcome.refused;
    }
    return outcome;
}

// Not an upload or a sample, which a file must not replace.
bool AssetFolder::is_free(const std::string& name) const {
    const Result<std::string> id = bake::asset_id(name);
    if (!id || ids_.contains(*id)) return false;
    const Result<proto::Asset> known = store_.asset(*id);
    return !known || known->status == proto::AssetStatus::failed || store_.content(known->id, source_key).ok();
}

std::optional<std::string> AssetFolder::name_of(const fs::path& file) {
    if (const auto known = names_.find(file); known != names_.end()) return known->second;
    std::string path = file.lexically_relative(folder_).generic_string();
    std::replace(path.begin(), path.end(), '/', '-');
    std::vector<std::string> candidates{asset_name_of(file.string()), file.filename().string(), path};
    for (std::size_t i = 2; i <= max_namesakes; ++i) candidates.push_back(path + "-" + std::to_string(i));
    for (const std::string& name : candidates) {
        if (!is_free(name)) continue;
        ids_.insert(*bake::asset_id(name));
        return names_[file] = name;
    }
    return std::nullopt;
}

bool AssetFolder::submit(const fs::path& file, const std::string& stamp) {
    const auto refuse = [&](const std::string& why) {
        std::fprintf(stderr, "%s: %s\n", file.c_str(), why.c_str());
        return false;
    };
    const std::optional<std::string> name = name_of(file);
    if (!name) return refuse("its name and its path are those of other assets");
    const std::string source = fs::absolute(file).string() + " " + stamp;
    if (Result<proto::Asset> known = store_.asset(*name)) {
        const Result<store::Store::Content> baked_of = store_.content(known->id, source_key);
        // An unchanged file that failed would fail again, and one that ends the program would do so at every start.
        if (baked_of && baked_of->record == source) return true;
        bakes_.cancel(known->id);
        (void)store_.remove_asset(known->id);
    }
    const Result<proto::Asset> asset = bakes_.submit(*name, file, source);
    if (!asset) {
        ids_.erase(*bake::asset_id(*name));
        names_.erase(file);
        return refuse(asset.error().message);
    }
    return true;
}

}  // namespace lodestream::cli
