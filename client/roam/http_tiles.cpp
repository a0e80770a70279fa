#include "client/roam/http_tiles.h"

#include <algorithm>
#include <utility>

#include "common/codec/level_codec.h"

namespace lodestream::roam {

namespace {

Result<render::Part> load(sdk::Client& client, const proto::Tileset& tileset, std::uint32_t node) {
    const std::string& uri = tileset.uris[node];
    const auto glb = client.fetch(uri, tileset.bytes[node]);
    if (!glb) return glb.error();
    const auto content = codec::decode_level(*glb);
    if (!content) return fail(content.error().code, uri + ": " + content.error().message);
    return render::prepare(*content, tileset.nodes.front().box);
}

}  // namespace

Result<std::unique_ptr<HttpTiles>> HttpTiles::open(const std::string& server, const proto::Tileset& tileset) {
    std::vector<sdk::Client> clients;
    for (std::size_t i = 0; i < connections; ++i) {
        auto client = sdk::Client::open(server);
        if (!client) return client.error();
        clients.push_back(*std::move(client));
    }
    return std::unique_ptr<HttpTiles>(new HttpTiles(std::move(clients), tileset));
}

HttpTiles::HttpTiles(std::vector<sdk::Client> clients, const proto::Tileset& tileset)
    : tileset_(tileset), clients_(std::move(clients)) {
    for (sdk::Client& client : clients_) workers_.emplace_back([this, &client] { work(client); });
}

HttpTiles::~HttpTiles() {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
    }
    changed_.notify_all();
    for (sdk::Client& client : clients_) client.cancel();
    for (std::thread& worker : workers_) worker.join();
}

void HttpTiles::want(std::span<const std::uint32_t> nodes, double) {
    {
        const std::lock_guard lock(mutex_);
        wanted_.assign(nodes.begin(), nodes.end());
        std::erase_if(wanted_, [&](std::uint32_t n) { return std::ranges::count(underway_, n) > 0; });
    }
    changed_.notify_all();
}

std::vector<Arrival> HttpTiles::take(double) {
    const std::lock_guard lock(mutex_);
    for (const Arrival& arrival : arrived_) std::erase(underway_, arrival.node);
    return std::exchange(arrived_, {});
}

void HttpTiles::work(sdk::Client& client) {
    for (;;) {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return stopping_ || !wanted_.empty(); });
        if (stopping_) return;
        const std::uint32_t node = wanted_.front();
        wanted_.erase(wanted_.begin());
        underway_.push_back(node);
        lock.unlock();
        Arrival arrival{node, load(client, tileset_, node)};
        lock.lock();
        arrived_.push_back(std::move(arrival));
    }
}

}  // namespace lodestream::roam
