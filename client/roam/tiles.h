// Where a roaming client gets a scene's tiles from; whatever is behind it, asking and taking never wait.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "client/render/renderer.h"
#include "common/base/result.h"
#include "proto/tileset.h"

namespace lodestream::roam {

struct Arrival {
    std::uint32_t node = 0;
    Result<render::Part> part;  // or why it did not come
};

// Times are those of the motion, seconds, and do not fall.
class Tiles {
  public:
    virtual ~Tiles() = default;

    // From now on these are to come, most urgent first, and no others.
    virtual void want(std::span<const std::uint32_t> nodes, double now_s) = 0;

    // From now on nodes are those of this tileset, which must outlive the next call. Nothing is wanted yet, and nothing
    // comes of a tileset before.
    virtual void adopt(const proto::Tileset& tileset) = 0;

    // What has come since. A tile that is no longer wanted may come too; one that was taken comes again if it is wanted
    // again.
    virtual std::vector<Arrival> take(double now_s) = 0;
};

}  // namespace lodestream::roam
