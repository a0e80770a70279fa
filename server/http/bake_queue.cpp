#include "server/http/bake_queue.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <set>
#include <thread>

#include "server/bake/bake.h"
#include "server/importer/importer.h"
#include "server/samples/samples.h"

namespace lodestream::http {

namespace {

constexpr std::string_view sample_prefix = "sample:";
constexpr const char* stopped = "the server stopped during the bake; send it again";

struct Job {
    proto::Asset asset;
    mesh::Model model;
    std::uint64_t bytes = 0;
    std::atomic<bool> cancelled{false};
    std::atomic<double> progress{0.0};
};

template <class T>
std::uint64_t bytes_of(const std::vector<T>& vector) {
    return vector.size() * sizeof(T);
}

std::uint64_t memory_of(const mesh::Model& model) {
    const mesh::Mesh& mesh = model.mesh;
    std::uint64_t bytes = bytes_of(mesh.positions) + bytes_of(mesh.normals) + bytes_of(mesh.texture_coordinates) +
                          bytes_of(mesh.colors) + bytes_of(mesh.triangles) + bytes_of(mesh.triangle_materials);
    for (const mesh::Image& image : model.images) bytes += image.bytes.size();
    return bytes;
}

Result<importer::Format> format_of(const std::vector<std::byte>& bytes, const std::string& name) {
    auto sniffed = importer::sniff_format(bytes);
    if (sniffed) return sniffed;
    const auto by_name = importer::format_of_extension(name);
    return by_name ? by_name : sniffed;
}

}  // namespace

struct BakeQueue::Impl {
    using Import = std::function<Result<mesh::Model>()>;

    store::Store& store;
    planner::Planner& planner;
    mutable std::mutex mutex;
    std::condition_variable work;
    std::condition_variable done;
    std::set<std::string> importing;  // ids
    std::deque<std::shared_ptr<Job>> waiting;
    std::shared_ptr<Job> running;
    std::uint64_t waiting_bytes = 0;
    std::atomic<bool> stopping{false};
    Counts counts;
    std::thread thread;

    Impl(store::Store& s, planner::Planner& p) : store(s), planner(p) {}

    Result<proto::Asset> submit(std::string name, const Import& import);
    Status reserve(const std::string& id);
    Result<proto::Asset> import_reserved(const std::string& id, const std::string& name, const Import& import);
    Status check_free(const std::string& id, const std::string& name, bool& failed_before) const;
    void run();
    void bake(Job& job);
    void count_end(bool ready, bool cancelled);
    void mark_failed(const proto::Asset& asset, const std::string& why);
    std::shared_ptr<Job> find(const std::string& id) const;
};

std::shared_ptr<Job> BakeQueue::Impl::find(const std::string& id) const {
    if (running && running->asset.id == id) return running;
    const auto it = std::find_if(waiting.begin(), waiting.end(), [&](const auto& job) { return job->asset.id == id; });
    return it == waiting.end() ? nullptr : *it;
}

Status BakeQueue::Impl::reserve(const std::string& id) {
    const std::lock_guard guard(mutex);
    if (stopping) return fail(ErrorCode::unavailable, "the server is stopping");
    if (waiting.size() + importing.size() >= max_waiting)
        return fail(ErrorCode::unavailable, std::to_string(max_waiting) + " models wait to be baked already");
    const auto job = find(id);
    if (job && job->cancelled)
        return fail(ErrorCode::unavailable, "the removed asset \"" + id + "\" is still being stopped");
    if (job || !importing.insert(id).second)
        return fail(ErrorCode::conflict, "asset \"" + id + "\" is being baked already");
    return Nothing{};
}

// A failed asset may be replaced under its name; anything else that is there may not.
Status BakeQueue::Impl::check_free(const std::string& id, const std::string& name, bool& failed_before) const {
    for (const std::string& key : {id, name}) {
        const auto known = store.asset(key);
        if (!known && known.error().code == ErrorCode::not_found) continue;
        if (!known) return known.error();
        if (known->id != id || known->status != proto::AssetStatus::failed)
            return fail(ErrorCode::conflict, "there is an asset \"" + known->name + "\" already; remove it first");
        failed_before = true;
    }
    return Nothing{};
}

Result<proto::Asset> BakeQueue::Impl::import_reserved(const std::string& id, const std::string& name,
                                                      const Import& import) {
    bool failed_before = false;
    if (auto status = check_free(id, name, failed_before); !status) return status.error();
    auto model = import();
    if (!model) return model.error();
    if (model->mesh.triangles.empty()) return invalid_input("the model has no triangles");

    const auto job = std::make_shared<Job>();
    job->bytes = memory_of(*model);
    job->asset.id = id;
    job->asset.name = name;
    job->asset.kind = mesh::kind_name(model->kind);
    job->asset.triangles = model->mesh.triangles.size();
    job->asset.vertices = model->mesh.positions.size();
    job->asset.warnings = std::move(model.warnings);
    job->model = *std::move(model);
    const proto::Asset asset = job->asset;

    const std::lock_guard guard(mutex);
    if (stopping) return fail(ErrorCode::unavailable, "the server is stopping");
    if (!waiting.empty() && waiting_bytes + job->bytes > max_waiting_bytes)
        return fail(ErrorCode::unavailable, "the models that wait to be baked fill the memory set aside for them");
    if (failed_before)
        if (auto status = store.remove_asset(id); !status) return status.error();
    if (auto status = store.put_asset(asset); !status) return status.error();
    waiting.push_back(job);
    waiting_bytes += job->bytes;
    work.notify_one();
    return asset;
}

Result<proto::Asset> BakeQueue::Impl::submit(std::string name, const Import& import) {
    const auto id = bake::asset_id(name);
    if (!id) return id.error();
    if (auto status = reserve(*id); !status) return status.error();
    auto asset = [&]() -> Result<proto::Asset> {
        try {
            return import_reserved(*id, name, import);
        } catch (const std::bad_alloc&) {
            return fail(ErrorCode::limit_exceeded, "\"" + name + "\" needs more memory than there is");
        } catch (const std::exception& e) {
            return fail(ErrorCode::internal, "the import of \"" + name + "\" failed: " + e.what());
        }
    }();
    const std::lock_guard guard(mutex);
    importing.erase(*id);
    done.notify_all();
    return asset;
}

void BakeQueue::Impl::mark_failed(const proto::Asset& asset, const std::string& why) {
    proto::Asset failed = asset;
    failed.status = proto::AssetStatus::failed;
    failed.error = why;
    failed.levels.clear();
    static_cast<void>(store.put_asset(failed));
}

void BakeQueue::Impl::count_end(bool ready, bool cancelled) {
    const std::lock_guard guard(mutex);
    ++(cancelled ? counts.cancelled : ready ? counts.ready : counts.failed);
}

void BakeQueue::Impl::bake(Job& job) {
    bake::BakeOptions options;
    options.progress = [&](double share) {
        job.progress = share;
        return !job.cancelled && !stopping;
    };
    bool ready = false;
    std::string why = "not enough memory, or an internal error";
    try {
        const auto baked = bake::bake(store, job.asset, std::move(job.model), options);
        ready = baked.ok();
        if (!ready) why = stopping ? stopped : baked.error().message;
    } catch (const std::exception& e) {
        why = e.what();
    }
    planner.forget(job.asset.id);
    if (job.cancelled)
        static_cast<void>(store.remove_asset(job.asset.id));
    else if (!ready)
        mark_failed(job.asset, why);
    count_end(ready, job.cancelled);
}

void BakeQueue::Impl::run() {
    std::unique_lock lock(mutex);
    for (;;) {
        work.wait(lock, [&] { return stopping || !waiting.empty(); });
        if (stopping) break;
        running = waiting.front();
        waiting.pop_front();
        waiting_bytes -= running->bytes;
        const auto job = running;
        lock.unlock();
        bake(*job);
        lock.lock();
        running.reset();
        done.notify_all();
    }
    for (const auto& job : waiting) mark_failed(job->asset, stopped);
    waiting.clear();
    done.notify_all();
}

BakeQueue::BakeQueue(store::Store& store, planner::Planner& planner) : impl_(std::make_unique<Impl>(store, planner)) {
    impl_->thread = std::thread([impl = impl_.get()] { impl->run(); });
}

BakeQueue::~BakeQueue() {
    {
        const std::lock_guard guard(impl_->mutex);
        impl_->stopping = true;
    }
    impl_->work.notify_all();
    impl_->thread.join();
}

Result<proto::Asset> BakeQueue::submit(std::string name, std::vector<std::byte> bytes) {
    return impl_->submit(name, [&]() -> Result<mesh::Model> {
        const std::vector<std::byte> file = std::move(bytes);  // freed after the import
        const auto format = format_of(file, name);
        if (!format) return format.error();
        return importer::import_model(file, *format, importer::no_side_files());
    });
}

Result<proto::Asset> BakeQueue::submit(const std::string& name, const std::filesystem::path& input) {
    return impl_->submit(name, [&]() -> Result<mesh::Model> {
        const std::string text = input.string();
        if (text.starts_with(sample_prefix))
            return samples::make_sample(std::string_view(text).substr(sample_prefix.size()));
        return importer::import_file(input);
    });
}

void BakeQueue::cancel(const std::string& asset_id) {
    std::unique_lock lock(impl_->mutex);
    const auto job = impl_->find(asset_id);
    if (!job) return;
    job->cancelled = true;
    if (job == impl_->running) {
        impl_->done.wait_for(lock, std::chrono::seconds(max_cancel_wait_s), [&] { return impl_->running != job; });
        return;
    }
    std::erase(impl_->waiting, job);
    impl_->waiting_bytes -= job->bytes;
    ++impl_->counts.cancelled;
    impl_->done.notify_all();
}

void BakeQueue::wait_until_idle() {
    std::unique_lock lock(impl_->mutex);
    impl_->done.wait(lock, [&] { return impl_->importing.empty() && impl_->waiting.empty() && !impl_->running; });
}

double BakeQueue::progress(const std::string& asset_id) const {
    const std::lock_guard guard(impl_->mutex);
    const auto job = impl_->find(asset_id);
    return job ? std::clamp(job->progress.load(), 0.0, 1.0) : 0.0;
}

BakeQueue::Counts BakeQueue::counts() const {
    const std::lock_guard guard(impl_->mutex);
    Counts counts = impl_->counts;
    counts.waiting = impl_->waiting.size() + (impl_->running ? 1 : 0);
    return counts;
}

}  // namespace lodestream::http
