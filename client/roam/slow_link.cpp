#include "client/roam/slow_link.h"

#include <algorithm>
#include <utility>

#include "client/roam/http_tiles.h"

namespace lodestream::roam {

double SlowLink::last_byte_s(const Request& request) const {
    const double bits = 8.0 * static_cast<double>(bytes_[request.node]);
    const double first_byte_s = std::max(free_s_, request.sent_s + link_.rtt_ms / 1e3);
    return first_byte_s + (link_.downlink_mbps > 0.0 ? bits / (1e6 * link_.downlink_mbps) : 0.0);
}

bool SlowLink::is_underway(std::uint32_t node) const {
    return std::ranges::count(underway_, node, &Request::node) > 0;
}

void SlowLink::send(double now_s) {
    while (!waiting_.empty() && underway_.size() < connections) {
        underway_.push_back({waiting_.front(), now_s});
        waiting_.pop_front();
    }
}

void SlowLink::adopt(const proto::Tileset& tileset) {
    tiles_.adopt(tileset);
    bytes_ = tileset.bytes;
    underway_.clear();
    waiting_.clear();
    here_.clear();
}

void SlowLink::want(std::span<const std::uint32_t> nodes, double now_s) {
    waiting_.assign(nodes.begin(), nodes.end());
    std::erase_if(waiting_, [&](std::uint32_t node) { return is_underway(node); });
    send(now_s);
    std::vector<std::uint32_t> all;
    for (const Request& request : underway_) all.push_back(request.node);
    all.insert(all.end(), waiting_.begin(), waiting_.end());
    std::erase_if(here_, [&](const auto& entry) { return std::ranges::count(all, entry.first) == 0; });
    std::erase_if(all, [&](std::uint32_t node) { return here_.contains(node); });
    tiles_.want(all, now_s);
}

std::vector<Arrival> SlowLink::take(double now_s) {
    for (Arrival& arrival : tiles_.take(now_s)) here_.insert_or_assign(arrival.node, std::move(arrival));
    std::vector<Arrival> arrived;
    while (!underway_.empty() && last_byte_s(underway_.front()) <= now_s) {
        auto tile = here_.extract(underway_.front().node);
        if (!tile) break;
        free_s_ = last_byte_s(underway_.front());
        underway_.pop_front();
        arrived.push_back(std::move(tile.mapped()));
        send(free_s_);
    }
    return arrived;
}

}  // namespace lodestream::roam
