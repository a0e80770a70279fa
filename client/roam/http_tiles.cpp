#include "client/roam/http_tiles.h"

#include <algorithm>
#include <utility>

#include "common/codec/level_codec.h"
#include "common/mesh/operations.h"

namespace lodestream::roam {

namespace {

void place(codec::Decoded& content, const Mat4d& matrix) {
    if (matrix == Mat4d(1.0)) return;
    for (codec::Primitive& primitive : content.primitives)
        primitive.mesh = mesh::placed(std::move(primitive.mesh), content.origin, matrix);
}

}  // namespace

Result<std::unique_ptr<HttpTiles>> HttpTiles::open(const std::string& server, const Box& scene) {
    std::vector<sdk::Client> clients;
    for (std::size_t i = 0; i < connections; ++i) {
        auto client = sdk::Client::open(server);
        if (!client) return client.error();
        clients.push_back(*std::move(client));
    }
    return std::unique_ptr<HttpTiles>(new HttpTiles(std::move(clients), scene));
}

HttpTiles::HttpTiles(std::vector<sdk::Client> clients, const Box& scene) : scene_(scene), clients_(std::move(clients)) {
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

void HttpTiles::adopt(const proto::Tileset& tileset) {
    const std::lock_guard lock(mutex_);
    tileset_ = &tileset;
    ++adopted_;
    wanted_.clear();
    underway_.clear();
    arrived_.clear();
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

Result<HttpTiles::Glb> HttpTiles::fetch(sdk::Client& client, const Source& source) {
    {
        const std::lock_guard lock(mutex_);
        if (const auto kept = kept_.find(source.uri); kept != kept_.end()) return kept->second;
    }
    auto bytes = client.fetch(source.uri, source.bytes);
    if (!bytes) return bytes.error();
    auto glb = std::make_shared<const std::vector<std::byte>>(*std::move(bytes));
    const std::lock_guard lock(mutex_);
    keep(source.uri, glb);
    return Glb(std::move(glb));
}

void HttpTiles::keep(const std::string& uri, const Glb& glb) {
    if (!kept_.emplace(uri, glb).second) return;
    kept_order_.push_back(uri);
    kept_bytes_ += glb->size();
    for (; kept_bytes_ > max_kept_bytes; kept_order_.pop_front()) {
        const auto oldest = kept_.find(kept_order_.front());
        kept_bytes_ -= oldest->second->size();
        kept_.erase(oldest);
    }
}

Result<render::Part> HttpTiles::load(sdk::Client& client, const Source& source) {
    const auto glb = fetch(client, source);
    if (!glb) return glb.error();
    auto content = codec::decode_level(**glb);
    if (!content) return fail(content.error().code, source.uri + ": " + content.error().message);
    place(*content, source.matrix);
    return render::prepare(*content, scene_);
}

void HttpTiles::work(sdk::Client& client) {
    for (;;) {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return stopping_ || !wanted_.empty(); });
        if (stopping_) return;
        const std::uint32_t node = wanted_.front();
        const std::uint64_t adopted = adopted_;
        const Source source{tileset_->uris[node], tileset_->bytes[node], tileset_->matrix(node)};
        wanted_.erase(wanted_.begin());
        underway_.push_back(node);
        lock.unlock();
        Arrival arrival{node, load(client, source)};
        lock.lock();
        if (adopted == adopted_) arrived_.push_back(std::move(arrival));
    }
}

}  // namespace lodestream::roam
