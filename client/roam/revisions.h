// The tilesets of a scene that changes while it is roamed: a thread of its own waits for each newer one.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "client/sdk/client.h"
#include "proto/tileset.h"

namespace lodestream::roam {

// Between two of them, so that a scene in steady motion does not take the link from its tiles.
inline constexpr std::chrono::milliseconds revision_interval{100};
inline constexpr std::chrono::milliseconds retry_interval{1'000};  // where the server cannot be asked

class Revisions {
  public:
    // Of the asset, later than `revision`. Errors: those of Client::open().
    static Result<std::unique_ptr<Revisions>> open(const std::string& server, const std::string& asset_id,
                                                   std::uint64_t revision);
    ~Revisions();  // waits for no server
    Revisions(const Revisions&) = delete;
    Revisions& operator=(const Revisions&) = delete;

    // The newest that has come since the last call, if one has. Never waits.
    std::optional<proto::Tileset> take();

  private:
    Revisions(sdk::Client client, std::string asset_id, std::uint64_t revision);
    void work();

    sdk::Client client_;
    const std::string asset_id_;
    std::uint64_t revision_;
    std::mutex mutex_;
    std::condition_variable stopped_;
    std::optional<proto::Tileset> newest_;
    bool stopping_ = false;
    std::thread worker_;
};

}  // namespace lodestream::roam
