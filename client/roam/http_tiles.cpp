#include "client/roam/http_tiles.h"

#include <algorithm>
#include <utility>

#include "common/codec/level_codec.h"
#include "common/codec/points_codec.h"
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

// pre: the mutex is held
HttpTiles::Source HttpTiles::source_of(std::uint32_t node) const {
    const auto content_of = [&](std::uint32_t n) { return Content{tileset_->uris[n], tileset_->bytes[n]}; };
    Source source{{}, tileset_->matrix(node), tileset_->is_additive};
    if (!source.is_points) {
        source.contents = {content_of(node)};
        return source;
    }
    const std::vector<std::uint32_t> path = path_to(tileset_->nodes, node);
    for (const std::uint32_t n : path) source.contents.push_back(content_of(n));
    source.branches = branches_of(tileset_->nodes, path);
    return source;
}

Result<HttpTiles::Glb> HttpTiles::fetch(sdk::Client& client, const Content& content) {
    {
        const std::lock_guard lock(mutex_);
        if (const auto kept = kept_.find(content.uri); kept != kept_.end()) return kept->second;
    }
    auto bytes = client.fetch(content.uri, content.bytes);
    if (!bytes) return bytes.error();
    auto glb = std::make_shared<const std::vector<std::byte>>(*std::move(bytes));
    const std::lock_guard lock(mutex_);
    keep(content.uri, glb);
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
    if (source.is_points) return load_points(client, source);
    const Content& only = source.contents.front();
    const auto glb = fetch(client, only);
    if (!glb) return glb.error();
    auto content = codec::decode_level(**glb);
    if (!content) return fail(content.error().code, only.uri + ": " + content.error().message);
    place(*content, source.matrix);
    return render::prepare(*content, scene_);
}

Result<render::Part> HttpTiles::load_points(sdk::Client& client, const Source& source) {
    std::vector<codec::Points> contents;
    for (const Content& one : source.contents) {
        const auto glb = fetch(client, one);
        if (!glb) return glb.error();
        auto decoded = codec::decode_points(**glb);
        if (!decoded) return fail(decoded.error().code, one.uri + ": " + decoded.error().message);
        contents.push_back(std::move(decoded->content));
    }
    return render::prepare(shown_by(source.branches, contents), scene_);
}

void HttpTiles::work(sdk::Client& client) {
    for (;;) {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return stopping_ || !wanted_.empty(); });
        if (stopping_) return;
        const std::uint32_t node = wanted_.front();
        const std::uint64_t adopted = adopted_;
        const Source source = source_of(node);
        wanted_.erase(wanted_.begin());
        underway_.push_back(node);
        lock.unlock();
        Arrival arrival{node, load(client, source)};
        lock.lock();
        if (adopted == adopted_) arrived_.push_back(std::move(arrival));
    }
}

}  // namespace lodestream::roam
