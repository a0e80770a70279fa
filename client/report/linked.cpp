#include "client/report/linked.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <mutex>
#include <thread>

namespace lodestream::report {

namespace {

using Clock = std::chrono::steady_clock;

// One transfer, and where its time goes.
struct Job {
    std::function<Status(sdk::Client&)> transfer;
    std::optional<double>* ms = nullptr;
};
using Jobs = std::array<std::vector<Job>, links.size()>;

template <class Transfer>
void add(Jobs& jobs, double bytes, double max_s, LinkTimes& times, const Transfer& transfer) {
    for (std::size_t link = 0; link < links.size(); ++link)
        if (8e-6 * bytes / links[link].downlink_mbps <= max_s) jobs[link].push_back({transfer, &times[link]});
}

Jobs jobs_of(std::vector<AssetResult>& assets, double max_s) {
    Jobs jobs;
    const auto fetch = [](const std::string& url, std::uint64_t bytes) {
        return [url, bytes](sdk::Client& client) -> Status {
            if (const auto content = client.fetch(url, bytes); !content) return content.error();
            return Nothing{};
        };
    };
    for (AssetResult& asset : assets) {
        for (DeviceResult& device : asset.devices) {
            const proto::PlanRequest request = device.sent_request;
            add(jobs, 0.0, max_s, device.linked_plan_ms, [request](sdk::Client& client) -> Status {
                if (const auto plan = client.plan(request); !plan) return plan.error();
                return Nothing{};
            });
            const auto& content = device.plan.content;
            add(jobs, static_cast<double>(content.bytes), max_s, device.linked_fetch_ms,
                fetch(content.url, content.bytes));
        }
        for (LadderLevel& rung : asset.ladder)
            add(jobs, static_cast<double>(rung.level.bytes), max_s, rung.linked_fetch_ms,
                fetch(rung.level.url, rung.level.bytes));
    }
    return jobs;
}

// The connection is made, and used once, before the clock starts: a click comes to a page that is there.
Status run(const std::string& server_url, const Link& link, const Job& job) {
    Result<sdk::Client> client = sdk::Client::open(server_url, link);
    if (!client) return client.error();
    if (const auto assets = client->assets(); !assets) return assets.error();
    const Clock::time_point start = Clock::now();
    if (Status done = job.transfer(*client); !done) return done;
    *job.ms = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
    return Nothing{};
}

Status run_side_by_side(const std::string& server_url, const Link& link, const std::vector<Job>& jobs) {
    std::atomic<std::size_t> next{0};
    std::mutex mutex;
    Status first = Nothing{};
    const auto work = [&] {
        for (std::size_t k = next++; k < jobs.size(); k = next++) {
            Status done = run(server_url, link, jobs[k]);
            const std::lock_guard lock(mutex);
            if (!done && first) first = std::move(done);
        }
    };
    const auto at_once = static_cast<std::size_t>(std::max(1.0, mbps_at_once / link.downlink_mbps));
    std::vector<std::jthread> threads;
    for (std::size_t i = 0; i < std::min(at_once, jobs.size()); ++i) threads.emplace_back(work);
    threads.clear();
    return first;
}

}  // namespace

Status measure_links(const std::string& server_url, double max_s, std::vector<AssetResult>& assets) {
    const Jobs jobs = jobs_of(assets, max_s);
    for (std::size_t link = 0; link < links.size(); ++link)
        if (Status done = run_side_by_side(server_url, links[link], jobs[link]); !done) return done;
    return Nothing{};
}

}  // namespace lodestream::report
