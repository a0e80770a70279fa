// Bakes one after the other on a thread of its own, so that requests are answered meanwhile.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/mesh/mesh.h"
#include "proto/messages.h"
#include "server/planner/planner.h"
#include "server/store/store.h"

namespace lodestream::http {

class BakeQueue {
  public:
    static constexpr std::size_t max_waiting = 256;
    static constexpr std::uint64_t max_waiting_bytes = 4ull << 30;  // of the imported models that wait; one always may
    static constexpr std::uint32_t max_cancel_wait_s = 5;

    BakeQueue(store::Store& store, planner::Planner& planner);
    ~BakeQueue();  // cancels the running bake and drops the waiting ones; their assets stay `failed` with the reason

    // Imports the bytes at once, so that bad input is told to the caller and nothing of it is kept; then the asset is
    // `baking`. Errors: the importer's; conflict (name taken); unavailable (queue full).
    Result<proto::Asset> submit(std::string name, std::vector<std::byte> bytes);
    // The same for a file (with its side files) or a built-in sample given as "sample:NAME[:COUNT]".
    Result<proto::Asset> submit(const std::string& name, const std::filesystem::path& input);

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
