// The scenes of a store that are changed while they are served, and the two threads that make their tiles true again:
// both first what is drawn nowhere at its place yet, one alone the levels above, so that a change never waits for
// these.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "common/base/result.h"
#include "proto/nodes.h"
#include "server/live/live_scene.h"
#include "server/live/transient_files.h"
#include "server/store/store.h"

namespace lodestream::live {

class LiveScenes {
  public:
    explicit LiveScenes(store::Store& store);  // which must outlive it
    ~LiveScenes();
    LiveScenes(const LiveScenes&) = delete;
    LiveScenes& operator=(const LiveScenes&) = delete;

    // The scene, opened where it is not; the same one to all until it is forgotten or baked anew. Errors: those of
    // LiveScene::open().
    Result<std::shared_ptr<LiveScene>> find(const proto::Asset& asset);
    // Only if its nodes were ever changed. Errors: likewise.
    Result<std::shared_ptr<LiveScene>> find_changed(const proto::Asset& asset);
    // LiveScene::change(), with what it makes untrue on its way.
    Result<proto::NodesChanged> change(const proto::Asset& asset, std::span<const proto::NodeChange> changes);

    // 0 where the scene is not open: nobody has changed it.
    std::uint64_t revision(const std::string& asset_id) const;

    // For the removal of an asset.
    void forget(const std::string& asset_id);

    // Until nothing has to be made any more; true, or false where that takes longer.
    bool wait_until_true(std::chrono::milliseconds most);

  private:
    using Work = std::function<bool(LiveScene&)>;
    void run(std::size_t worker, const Work& work);
    std::vector<std::shared_ptr<LiveScene>> all() const;
    // Null where it is not open, or of an older bake, which is then forgotten.
    std::shared_ptr<LiveScene> opened(const std::string& asset_id);

    store::Store& store_;
    const std::shared_ptr<TransientFiles> files_;
    std::mutex opening_;
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::map<std::string, std::shared_ptr<LiveScene>> scenes_;
    std::array<bool, 2> is_idle_{};  // of each worker, since the last change
    std::atomic<bool> stopping_{false};
    std::vector<std::thread> workers_;
};

}  // namespace lodestream::live
