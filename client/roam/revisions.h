// A scene's tileset while it is roamed: threads of their own wait for each newer revision and fetch the documents that
// the view asks for.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "client/sdk/client.h"
#include "proto/tileset.h"

namespace lodestream::roam {

// Between two of them, so that a scene in steady motion does not take the link from its tiles.
inline constexpr std::chrono::milliseconds revision_interval{100};
inline constexpr std::chrono::milliseconds retry_interval{1'000};  // where the server cannot be asked

class Revisions {
  public:
    // Of the asset, from this tileset on. Errors: those of Client::open().
    static Result<std::unique_ptr<Revisions>> open(const std::string& server, const std::string& asset_id,
                                                   proto::Tileset tileset);
    ~Revisions();  // waits for no server
    Revisions(const Revisions&) = delete;
    Revisions& operator=(const Revisions&) = delete;

    // The newest that there is since the last call, if there is one: with the documents that were opened, as far as
    // they are here. Never waits.
    std::optional<proto::Tileset> take();

    // Opens these documents, the first one first, and no others that are not opened yet. Never waits.
    void open_documents(const std::vector<std::string>& addresses);

  private:
    Revisions(sdk::Client revisions, sdk::Client documents, std::string asset_id, proto::Tileset tileset);
    void follow();
    void read_documents();
    struct Document {
        std::string address;
        std::shared_ptr<const proto::Tileset> told;
    };
    using Documents = std::map<std::uint64_t, Document>;  // by the ids of their tiles
    // With what was opened of the tileset before; of that, what has changed is read again.
    Result<proto::Tileset> reopened(proto::Tileset newer, Documents& opened);

    sdk::Client revisions_client_, documents_client_;  // each of one thread
    const std::string asset_id_;
    std::mutex mutex_;
    std::condition_variable changed_;
    proto::Tileset tileset_;
    bool is_newer_ = false;               // than what take() has given
    Documents opened_;                    // that are in the tileset
    std::vector<std::string> addresses_;  // of documents to be opened
    std::set<std::string> broken_;        // those that will not come
    bool stopping_ = false;
    std::thread follower_, reader_;
};

}  // namespace lodestream::roam
