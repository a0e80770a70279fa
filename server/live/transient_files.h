// Files of a store that are served as long as something refers to them, and a while longer for clients that have just
// been told of them.
#pragma once

#include <chrono>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>

#include "common/base/result.h"
#include "server/store/store.h"

namespace lodestream::live {

inline constexpr std::chrono::seconds transient_grace{60};

// Keeps a file while it lives.
using FileKeeper = std::shared_ptr<const void>;

class TransientFiles : public std::enable_shared_from_this<TransientFiles> {
  public:
    using Clock = std::chrono::steady_clock;

    // `store` must outlive this and all keepers.
    explicit TransientFiles(store::Store& store) : store_(store) {}

    struct Kept {
        store::StoredFile file;
        FileKeeper keeper;
    };
    Result<Kept> put(std::span<const std::byte> glb);

    // Removes what nothing has referred to for transient_grace.
    void sweep(Clock::time_point now);

  private:
    void release(const std::string& hash);

    store::Store& store_;
    std::mutex mutex_;
    std::map<std::string, std::size_t> keepers_;  // of each hash
    struct Released {
        std::string hash;
        Clock::time_point at;
    };
    std::deque<Released> released_;  // the longest ago first
};

}  // namespace lodestream::live
