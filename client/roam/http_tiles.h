// Tiles from the server: threads of their own fetch, decode and make ready for the GPU, the most urgent first.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "client/roam/shown_points.h"
#include "client/roam/tiles.h"
#include "client/sdk/client.h"
#include "proto/tileset.h"

namespace lodestream::roam {

// Few, so that most of what is asked for can still be cancelled: what a connection has begun is finished, which is
// cheaper than a new connection.
inline constexpr std::size_t connections = 6;

// Of encoded contents that are kept so that what moves need not be fetched again.
inline constexpr std::uint64_t max_kept_bytes = 64ull << 20;

class HttpTiles : public Tiles {
  public:
    // Connects when the first tile is wanted. Parts are prepared for a scene of this box. Errors: those of
    // Client::open().
    static Result<std::unique_ptr<HttpTiles>> open(const std::string& server, const Box& scene);
    ~HttpTiles() override;  // waits for no server
    HttpTiles(const HttpTiles&) = delete;
    HttpTiles& operator=(const HttpTiles&) = delete;

    void adopt(const proto::Tileset& tileset) override;
    void want(std::span<const std::uint32_t> nodes, double now_s) override;
    std::vector<Arrival> take(double now_s) override;

  private:
    // What there is to fetch.
    struct Content {
        std::string uri;
        std::uint64_t bytes = 0;
    };
    // Of a node: its content, and where it goes; of points, those of the tiles above it and its own.
    struct Source {
        std::vector<Content> contents;
        Mat4d matrix{1.0};
        bool is_points = false;
        std::vector<Branch> branches{};  // of points: on the way down to it
    };
    using Glb = std::shared_ptr<const std::vector<std::byte>>;

    HttpTiles(std::vector<sdk::Client> clients, const Box& scene);
    void work(sdk::Client& client);
    Result<render::Part> load(sdk::Client& client, const Source& source);
    Source source_of(std::uint32_t node) const;
    Result<render::Part> load_points(sdk::Client& client, const Source& source);
    Result<Glb> fetch(sdk::Client& client, const Content& content);
    void keep(const std::string& uri, const Glb& glb);

    const Box scene_;
    std::vector<sdk::Client> clients_;  // one a worker
    std::mutex mutex_;
    std::condition_variable changed_;
    std::vector<std::uint32_t> wanted_;    // most urgent first, without those under way
    std::vector<std::uint32_t> underway_;  // being fetched, or here and not taken yet
    std::vector<Arrival> arrived_;
    const proto::Tileset* tileset_ = nullptr;
    std::uint64_t adopted_ = 0;           // tilesets
    std::map<std::string, Glb> kept_;     // by uri
    std::deque<std::string> kept_order_;  // the longest ago first
    std::uint64_t kept_bytes_ = 0;
    bool stopping_ = false;
    std::vector<std::thread> workers_;
};

}  // namespace lodestream::roam
