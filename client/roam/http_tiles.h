// Tiles from the server: threads of their own fetch, decode and make ready for the GPU, the most urgent first.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "client/roam/tiles.h"
#include "client/sdk/client.h"
#include "proto/tileset.h"

namespace lodestream::roam {

// Few, so that most of what is asked for can still be cancelled: what a connection has begun is finished, which is
// cheaper than a new connection.
inline constexpr std::size_t connections = 6;

class HttpTiles : public Tiles {
  public:
    // Connects when the first tile is wanted; `tileset` must outlive it. Errors: those of Client::open().
    static Result<std::unique_ptr<HttpTiles>> open(const std::string& server, const proto::Tileset& tileset);
    ~HttpTiles() override;  // waits for no server
    HttpTiles(const HttpTiles&) = delete;
    HttpTiles& operator=(const HttpTiles&) = delete;

    void want(std::span<const std::uint32_t> nodes, double now_s) override;
    std::vector<Arrival> take(double now_s) override;

  private:
    HttpTiles(std::vector<sdk::Client> clients, const proto::Tileset& tileset);
    void work(sdk::Client& client);

    const proto::Tileset& tileset_;
    std::vector<sdk::Client> clients_;  // one a worker
    std::mutex mutex_;
    std::condition_variable changed_;
    std::vector<std::uint32_t> wanted_;    // most urgent first, without those under way
    std::vector<std::uint32_t> underway_;  // being fetched, or here and not taken yet
    std::vector<Arrival> arrived_;
    bool stopping_ = false;
    std::vector<std::thread> workers_;
};

}  // namespace lodestream::roam
