// Bakes one after the other on a thread of its own, so that requests are answered meanwhile. What waits lies in the
// store, so a restart goes on where the program ended.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/mesh/mesh.h"
#include "proto/messages.h"
#include "server/bake/limits.h"
#include "server/planner/planner.h"
#include "server/store/store.h"

namespace lodestream::http {

class BakeQueue {
  public:
    static constexpr std::size_t max_waiting = 256;
    static constexpr std::uint64_t max_waiting_bytes =
        16ull << 30;  // of the imported models that wait, in the store; one always may
    static constexpr std::uint32_t max_cancel_wait_s = 5;

    // Goes on with the bakes that the store's last program left.
    BakeQueue(store::Store& store, planner::Planner& planner, const bake::Limits& limits = {});
    ~BakeQueue();  // stops the running bake; it and the waiting ones stay `baking` until the store is opened again

    // Imports the bytes at once, so that bad input is told to the caller and nothing of it is kept; then the asset is
    // `baking` with its first levels. Errors: the importer's; conflict (name taken); unavailable (queue full);
    // limit_exceeded (memory).
    Result<proto::Asset> submit(std::string name, std::vector<std::byte> bytes);
    // The same for a file (with its side files) or a built-in sample given as "sample:NAME[:COUNT]". `origin`: kept
    // with the asset as the record of its content origin_key, from before the bake can start; empty: none.
    Result<proto::Asset> submit(const std::string& name, const std::filesystem::path& input,
                                const std::string& origin = {});
    static constexpr std::string_view origin_key = "source";

    // For the removal of an asset: stops its bake and waits max_cancel_wait_s for that. A bake that stops later removes
    // what it has stored meanwhile by itself.
    void cancel(const std::string& asset_id);
    void wait_until_idle();
    double progress(const std::string& asset_id) const;  // [0,1]

    struct Counts {
        std::uint64_t ready = 0;  // bakes ended, since the start
        std::uint64_t failed = 0;
        std::uint64_t cancelled = 0;
        std::uint64_t waiting = 0;  // now, the running one included
    };
    Counts counts() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace lodestream::http
