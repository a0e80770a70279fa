#include "client/roam/revisions.h"

#include <algorithm>
#include <utility>

namespace lodestream::roam {

Result<std::unique_ptr<Revisions>> Revisions::open(const std::string& server, const std::string& asset_id,
                                                   std::uint64_t revision) {
    auto client = sdk::Client::open(server);
    if (!client) return client.error();
    return std::unique_ptr<Revisions>(new Revisions(*std::move(client), asset_id, revision));
}

Revisions::Revisions(sdk::Client client, std::string asset_id, std::uint64_t revision)
    : client_(std::move(client)), asset_id_(std::move(asset_id)), revision_(revision), worker_([this] { work(); }) {}

Revisions::~Revisions() {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
    }
    stopped_.notify_all();
    client_.cancel();
    worker_.join();
}

std::optional<proto::Tileset> Revisions::take() {
    const std::lock_guard lock(mutex_);
    return std::exchange(newest_, std::nullopt);
}

void Revisions::work() {
    std::unique_lock lock(mutex_);
    while (!stopping_) {
        lock.unlock();
        auto newer = client_.newer_tileset(asset_id_, revision_);
        lock.lock();
        // One whose tiles cannot be fetched within known bounds is none.
        const bool is_usable = newer && *newer && std::ranges::count((*newer)->bytes, 0u) == 0;
        if (newer && *newer) revision_ = (*newer)->revision;
        if (is_usable) newest_ = *std::move(*newer);
        stopped_.wait_for(lock, newer ? revision_interval : retry_interval, [&] { return stopping_; });
    }
}

}  // namespace lodestream::roam
