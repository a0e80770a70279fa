#include "client/roam/revisions.h"

#include <algorithm>
#include <utility>

namespace lodestream::roam {

namespace {

// One whose tiles cannot be fetched within known bounds is none.
bool is_usable(const proto::Tileset& tileset) {
    return std::ranges::count(tileset.bytes, 0u) == 0;
}

// What the network fails to bring may come at another time.
bool may_come(const Error& error) {
    return error.code == ErrorCode::io || error.code == ErrorCode::unavailable;
}

}  // namespace

Result<std::unique_ptr<Revisions>> Revisions::open(const std::string& server, const std::string& asset_id,
                                                   proto::Tileset tileset) {
    auto revisions = sdk::Client::open(server), documents = sdk::Client::open(server);
    if (!revisions) return revisions.error();
    if (!documents) return documents.error();
    return std::unique_ptr<Revisions>(
        new Revisions(*std::move(revisions), *std::move(documents), asset_id, std::move(tileset)));
}

Revisions::Revisions(sdk::Client revisions, sdk::Client documents, std::string asset_id, proto::Tileset tileset)
    : revisions_client_(std::move(revisions)),
      documents_client_(std::move(documents)),
      asset_id_(std::move(asset_id)),
      tileset_(std::move(tileset)),
      follower_([this] { follow(); }),
      reader_([this] { read_documents(); }) {}

Revisions::~Revisions() {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
    }
    changed_.notify_all();
    revisions_client_.cancel();
    documents_client_.cancel();
    follower_.join();
    reader_.join();
}

std::optional<proto::Tileset> Revisions::take() {
    const std::lock_guard lock(mutex_);
    if (!std::exchange(is_newer_, false)) return std::nullopt;
    return tileset_;
}

void Revisions::open_documents(const std::vector<std::string>& addresses) {
    {
        const std::lock_guard lock(mutex_);
        if (addresses_ == addresses) return;
        addresses_ = addresses;
    }
    changed_.notify_all();
}

Result<proto::Tileset> Revisions::reopened(proto::Tileset newer, Documents& opened) {
    for (std::uint32_t node = 0; node < newer.nodes.size(); ++node) {
        if (!proto::begins_document(newer, node) || newer.ids.empty()) continue;
        const auto known = opened.find(newer.ids[node]);
        if (known == opened.end()) continue;
        Document& document = known->second;
        if (document.address != newer.documents[node]) {
            auto read = revisions_client_.document(newer.documents[node], newer.matrix(node));
            if (!read) return read.error();
            document = {newer.documents[node], std::make_shared<const proto::Tileset>(*std::move(read))};
        }
        if (Status added = proto::add_document(newer, node, *document.told); !added) return added.error();
    }
    return newer;
}

void Revisions::follow() {
    std::unique_lock lock(mutex_);
    std::uint64_t revision = tileset_.revision;
    while (!stopping_) {
        Documents opened = opened_;
        lock.unlock();
        auto newer = revisions_client_.newer_tileset(asset_id_, revision);
        const bool is_told = newer.ok(), has_come = is_told && *newer;
        const std::uint64_t come = has_come ? (*newer)->revision : revision;
        std::optional<Result<proto::Tileset>> whole;
        if (has_come) whole = reopened(**std::move(newer), opened);
        lock.lock();
        const bool is_read = !has_come || *whole;
        if (is_read) revision = come;
        if (has_come && is_read && is_usable(**whole)) {
            tileset_ = **std::move(whole);
            opened_ = std::move(opened);
            is_newer_ = true;
        }
        const bool is_well = is_told && is_read;
        changed_.wait_for(lock, is_well ? revision_interval : retry_interval, [&] { return stopping_; });
    }
}

void Revisions::read_documents() {
    std::unique_lock lock(mutex_);
    const auto node_of = [&](const std::string& address) {
        return static_cast<std::size_t>(std::ranges::find(tileset_.documents, address) - tileset_.documents.begin());
    };
    while (!stopping_) {
        std::erase_if(addresses_, [&](const std::string& address) {
            return broken_.contains(address) || node_of(address) == tileset_.documents.size();
        });
        if (addresses_.empty()) {
            changed_.wait(lock, [&] { return stopping_ || !addresses_.empty(); });
            continue;
        }
        const std::string address = addresses_.front();
        const Mat4d place = tileset_.matrix(node_of(address));
        lock.unlock();
        auto document = documents_client_.document(address, place);
        lock.lock();
        if (!document && may_come(document.error())) {
            changed_.wait_for(lock, retry_interval, [&] { return stopping_; });
            continue;
        }
        // Meanwhile a newer revision may have come, which names another one.
        const std::size_t node = node_of(address);
        if (node == tileset_.documents.size()) continue;
        if (document && is_usable(*document) &&
            proto::add_document(tileset_, static_cast<std::uint32_t>(node), *document)) {
            if (!tileset_.ids.empty())
                opened_[tileset_.ids[node]] = {address, std::make_shared<const proto::Tileset>(*std::move(document))};
            is_newer_ = true;
        } else {
            broken_.insert(address);
        }
    }
}

}  // namespace lodestream::roam
