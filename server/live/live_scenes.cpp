#include "server/live/live_scenes.h"

#include <algorithm>
#include <exception>
#include <utility>

namespace lodestream::live {

namespace {

// Between two looks for what has come to rest, and for files that nothing refers to.
constexpr std::chrono::milliseconds look_interval{500};

// Nothing of a scene that cannot be made ends the program; its tiles stay off by what they say.
bool without_throwing(const std::function<bool(LiveScene&)>& work, LiveScene& scene) {
    try {
        return work(scene);
    } catch (const std::exception&) {
        return false;
    }
}

}  // namespace

LiveScenes::LiveScenes(store::Store& store) : store_(store), files_(std::make_shared<TransientFiles>(store)) {
    // What is behind comes first, to both.
    const std::array<Work, 2> works{
        [](LiveScene& scene) { return scene.make_rest(); },
        [this](LiveScene& scene) { return scene.make_rest() || scene.make_above([this] { return !stopping_; }); }};
    for (std::size_t worker = 0; worker < works.size(); ++worker)
        workers_.emplace_back([this, worker, work = works[worker]] { run(worker, work); });
}

LiveScenes::~LiveScenes() {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
    }
    changed_.notify_all();
    for (std::thread& worker : workers_) worker.join();
}

std::vector<std::shared_ptr<LiveScene>> LiveScenes::all() const {
    const std::lock_guard lock(mutex_);
    std::vector<std::shared_ptr<LiveScene>> scenes;
    for (const auto& [id, scene] : scenes_) scenes.push_back(scene);
    return scenes;
}

void LiveScenes::run(std::size_t worker, const Work& work) {
    while (!stopping_) {
        {
            const std::lock_guard lock(mutex_);
            is_idle_[worker] = true;  // unless a change comes meanwhile, or there is work
        }
        bool has_worked = false;
        for (const std::shared_ptr<LiveScene>& scene : all())
            if (!stopping_) has_worked = without_throwing(work, *scene) || has_worked;
        files_->sweep(TransientFiles::Clock::now());
        std::unique_lock lock(mutex_);
        if (has_worked) is_idle_[worker] = false;
        if (is_idle_[worker]) {
            changed_.notify_all();
            changed_.wait_for(lock, look_interval, [&] { return stopping_ || !is_idle_[worker]; });
        }
    }
}

std::shared_ptr<LiveScene> LiveScenes::opened(const std::string& asset_id) {
    std::shared_ptr<LiveScene> scene;
    {
        const std::lock_guard lock(mutex_);
        const auto found = scenes_.find(asset_id);
        if (found == scenes_.end()) return nullptr;
        scene = found->second;
    }
    if (scene->is_current()) return scene;
    const std::lock_guard lock(mutex_);
    if (const auto found = scenes_.find(asset_id); found != scenes_.end() && found->second == scene)
        scenes_.erase(found);
    return nullptr;
}

Result<std::shared_ptr<LiveScene>> LiveScenes::find(const proto::Asset& asset) {
    const std::lock_guard one_at_a_time(opening_);
    if (auto known = opened(asset.id)) return known;
    Result<std::shared_ptr<LiveScene>> scene = LiveScene::open(store_, asset, files_);
    if (!scene) return scene;
    const std::lock_guard lock(mutex_);
    scenes_[asset.id] = *scene;
    is_idle_.fill(false);
    changed_.notify_all();
    return scene;
}

Result<std::shared_ptr<LiveScene>> LiveScenes::find_changed(const proto::Asset& asset) {
    if (auto known = opened(asset.id)) return known->revision() > 0 ? known : std::shared_ptr<LiveScene>();
    const Result<bool> has_changed = store_.has_nodes(asset.id);
    if (!has_changed) return has_changed.error();
    return *has_changed ? find(asset) : std::shared_ptr<LiveScene>();
}

Result<proto::NodesChanged> LiveScenes::change(const proto::Asset& asset, std::span<const proto::NodeChange> changes) {
    const Result<std::shared_ptr<LiveScene>> scene = find(asset);
    if (!scene) return scene.error();
    Result<proto::NodesChanged> changed = (*scene)->change(changes);
    if (!changed) return changed;
    const std::lock_guard lock(mutex_);
    is_idle_.fill(false);
    changed_.notify_all();
    return changed;
}

std::uint64_t LiveScenes::revision(const std::string& asset_id) const {
    std::shared_ptr<LiveScene> scene;
    {
        const std::lock_guard lock(mutex_);
        const auto found = scenes_.find(asset_id);
        if (found == scenes_.end()) return 0;
        scene = found->second;
    }
    return scene->revision();
}

void LiveScenes::forget(const std::string& asset_id) {
    std::shared_ptr<LiveScene> scene;  // its end waits for the disk: not within the lock
    const std::lock_guard lock(mutex_);
    if (const auto found = scenes_.find(asset_id); found != scenes_.end()) {
        scene = std::move(found->second);
        scenes_.erase(found);
    }
}

bool LiveScenes::wait_until_true(std::chrono::milliseconds most) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, most, [&] { return is_idle_[0] && is_idle_[1]; });
}

}  // namespace lodestream::live
