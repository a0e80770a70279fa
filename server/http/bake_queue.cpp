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

struct Job {
    std::string id;
    std::uint64_t bytes = 0;
    std::atomic<bool> cancelled{false};
    std::atomic<double> progress{0.0};
};

Result<importer::Format> format_of(const std::vector<std::byte>& bytes, const std::string& name) {
    auto sniffed = importer::sniff_format(bytes);
    if (sniffed) return sniffed;
    const auto by_name = importer::format_of_extension(name);
    return by_name ? by_name : sniffed;
}

}  // namespace

struct BakeQueue::Impl {
    using Import = std::function<Result<mesh::Model>()>;
    struct Submission {
        std::string id, name, origin;
    };

    store::Store& store;
    planner::Planner& planner;
    const bake::Limits limits;
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

    Impl(store::Store& s, planner::Planner& p, const bake::Limits& l) : store(s), planner(p), limits(l) {}

    void go_on();
    Result<proto::Asset> submit(const std::string& name, const std::string& origin, const Import& import);
    Status reserve(const std::string& id);
    Result<proto::Asset> import_reserved(const Submission& submission, const Import& import);
    Status check_room(std::uint64_t bytes) const;
    Result<proto::Asset> prepare(const Submission& submission, mesh::Model model, std::vector<std::string> warnings);
    void push(const std::string& id, std::uint64_t bytes);
    Status check_free(const std::string& id, const std::string& name, bool& failed_before) const;
    void run();
    void bake(Job& job);
    void count_end(const Job& job, bool ready);
    std::shared_ptr<Job> find(const std::string& id) const;
};

std::shared_ptr<Job> BakeQueue::Impl::find(const std::string& id) const {
    if (running && running->id == id) return running;
    const auto it = std::find_if(waiting.begin(), waiting.end(), [&](const auto& job) { return job->id == id; });
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

// pre: mutex is held
Status BakeQueue::Impl::check_room(std::uint64_t bytes) const {
    if (stopping) return fail(ErrorCode::unavailable, "the server is stopping");
    if (!waiting.empty() && waiting_bytes + bytes > max_waiting_bytes)
        return fail(ErrorCode::unavailable, "the models that wait to be baked fill the space set aside for them");
    return Nothing{};
}

// pre: mutex is held
void BakeQueue::Impl::push(const std::string& id, std::uint64_t bytes) {
    const auto job = std::make_shared<Job>();
    job->id = id;
    job->bytes = bytes;
    waiting.push_back(job);
    waiting_bytes += bytes;
    work.notify_one();
}

void BakeQueue::Impl::go_on() {
    const auto interrupted = bake::recover(store);
    if (!interrupted) return;
    const std::lock_guard guard(mutex);
    for (const std::string& id : *interrupted)
        if (const auto kept = store.content(id, bake::imported_key)) push(id, kept->file.bytes);
}

Result<proto::Asset> BakeQueue::Impl::prepare(const Submission& submission, mesh::Model model,
                                              std::vector<std::string> warnings) {
    proto::Asset asset;
    asset.id = submission.id;
    asset.name = submission.name;
    asset.warnings = std::move(warnings);
    auto prepared = bake::prepare(store, std::move(asset), model, limits);
    if (!prepared || submission.origin.empty()) return prepared;
    const auto origin = std::as_bytes(std::span(submission.origin));
    if (auto kept = store.put_content(submission.id, origin_key, "txt", origin, submission.origin); !kept)
        return kept.error();
    return prepared;
}

Result<proto::Asset> BakeQueue::Impl::import_reserved(const Submission& submission, const Import& import) {
    bool failed_before = false;
    if (auto status = check_free(submission.id, submission.name, failed_before); !status) return status.error();
    auto model = import();
    if (!model) return model.error();
    if (bake::is_empty(*model)) return invalid_input("the model has no triangles");
    if (auto fits = bake::check_memory(*model, limits); !fits) return fits.error();

    const std::uint64_t bytes = bake::memory_bytes(*model);
    {
        const std::lock_guard guard(mutex);
        if (auto room = check_room(bytes); !room) return room.error();
    }
    if (failed_before)
        if (auto status = store.remove_asset(submission.id); !status) return status.error();
    std::vector<std::string> warnings = std::move(model.warnings);
    auto asset = prepare(submission, *std::move(model), std::move(warnings));
    if (!asset) return asset;
    const std::lock_guard guard(mutex);
    push(submission.id, bytes);
    return asset;
}

Result<proto::Asset> BakeQueue::Impl::submit(const std::string& name, const std::string& origin, const Import& import) {
    const auto id = bake::asset_id(name);
    if (!id) return id.error();
    if (auto status = reserve(*id); !status) return status.error();
    auto asset = [&]() -> Result<proto::Asset> {
        try {
            return import_reserved({*id, name, origin}, import);
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

void BakeQueue::Impl::count_end(const Job& job, bool ready) {
    const std::lock_guard guard(mutex);
    if (job.cancelled)
        ++counts.cancelled;
    else if (ready)
        ++counts.ready;
    else if (!stopping)
        ++counts.failed;
}

void BakeQueue::Impl::bake(Job& job) {
    bake::BakeOptions options;
    options.limits = limits;
    options.progress = [&](double share) {
        job.progress = share;
        return !job.cancelled;
    };
    options.pause = [&] { return stopping && !job.cancelled; };
    const bool ready = bake::bake_prepared(store, job.id, options).ok();
    planner.forget(job.id);
    if (job.cancelled) static_cast<void>(store.remove_asset(job.id));
    count_end(job, ready);
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
    waiting.clear();
    done.notify_all();
}

BakeQueue::BakeQueue(store::Store& store, planner::Planner& planner, const bake::Limits& limits)
    : impl_(std::make_unique<Impl>(store, planner, limits)) {
    impl_->go_on();
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
    return impl_->submit(name, {}, [&]() -> Result<mesh::Model> {
        const std::vector<std::byte> file = std::move(bytes);  // freed after the import
        const auto format = format_of(file, name);
        if (!format) return format.error();
        return importer::import_model(file, *format, importer::no_side_files());
    });
}

Result<proto::Asset> BakeQueue::submit(const std::string& name, const std::filesystem::path& input,
                                       const std::string& origin) {
    return impl_->submit(name, origin, [&]() -> Result<mesh::Model> {
        const std::string text = input.string();
        if (text.starts_with(sample_prefix))
            return samples::make_sample(std::string_view(text).substr(sample_prefix.size()));
        return importer::import_file(input);
    });
}

void BakeQueue::cancel(const std::string& asset_id) {
    std::unique_lock lock(impl_->mutex);
    constexpr std::chrono::seconds patience(max_cancel_wait_s);
    impl_->done.wait_for(lock, patience, [&] { return !impl_->importing.contains(asset_id); });
    const auto job = impl_->find(asset_id);
    if (!job) return;
    job->cancelled = true;
    if (job == impl_->running) {
        impl_->done.wait_for(lock, patience, [&] { return impl_->running != job; });
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
