// A slower network than the one that is there, in the motion's time: what it shows of a scene does not hang on how fast
// this computer draws.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <vector>

#include "client/roam/tiles.h"
#include "client/sdk/client.h"

namespace lodestream::roam {

// As over so many connections (http_tiles.h) that share the link: tiles come one after the other in the order in which
// they were sent for, and never before they are here in truth. What waits for a connection can be cancelled.
class SlowLink : public Tiles {
  public:
    // `tiles` must outlive it. The link is that of all tiles together; what is kept of a tileset before comes over it
    // again.
    SlowLink(Tiles& tiles, const sdk::Link& link) : tiles_(tiles), link_(link) {}

    void adopt(const proto::Tileset& tileset) override;
    void want(std::span<const std::uint32_t> nodes, double now_s) override;
    std::vector<Arrival> take(double now_s) override;

  private:
    struct Request {
        std::uint32_t node = 0;
        double sent_s = 0.0;
    };
    void send(double now_s);
    double last_byte_s(const Request& request) const;
    bool is_underway(std::uint32_t node) const;

    Tiles& tiles_;
    std::vector<std::uint64_t> bytes_;
    sdk::Link link_;
    std::deque<Request> underway_;
    std::deque<std::uint32_t> waiting_;
    std::map<std::uint32_t, Arrival> here_;  // in truth
    double free_s_ = 0.0;                    // when the last tile that came left the link free
};

}  // namespace lodestream::roam
