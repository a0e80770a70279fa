#include "server/http/metrics.h"

#include <charconv>

#include "common/budget/budget.h"

namespace lodestream::http {

namespace {

std::string number(double value) {
    std::array<char, 400> text{};  // as long as the largest double
    return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed).ptr};
}

class Page {
  public:
    void family(const char* name, const char* type, const char* help) {
        name_ = name;
        text_ += "# HELP " + name_ + " " + help + "\n# TYPE " + name_ + " " + type + "\n";
    }
    void sample(const std::string& labels, const std::string& value, const char* suffix = "") {
        text_ += name_ + suffix + "{" + labels + "} " + value + "\n";
    }
    void sample(const std::string& labels, std::uint64_t value, const char* suffix = "") {
        sample(labels, std::to_string(value), suffix);
    }
    void plain(std::uint64_t value) { text_ += name_ + " " + std::to_string(value) + "\n"; }
    std::string take() { return std::move(text_); }

  private:
    std::string name_;
    std::string text_;
};

std::string label(const char* name, const std::string& value) {
    return std::string(name) + "=\"" + value + "\"";
}

}  // namespace

void Metrics::count_request(std::string_view method, std::string_view route, int status, double seconds,
                            std::uint64_t bytes) {
    const std::string name(route);
    const std::lock_guard guard(mutex_);
    ++requests_[{std::string(method), name, status}];
    bytes_[name] += bytes;
    Latency& latency = latencies_[name];
    ++latency.count;
    latency.sum_s += seconds;
    for (std::size_t i = 0; i < bucket_limits_s.size(); ++i) latency.buckets[i] += seconds <= bucket_limits_s[i];
}

void Metrics::count_plan(const std::string& limited_by) {
    const std::lock_guard guard(mutex_);
    ++plans_[limited_by];
}

std::string Metrics::text(const BakeQueue::Counts& bakes, const std::vector<proto::Asset>& assets) const {
    Page page;
    const std::lock_guard guard(mutex_);
    page.family("lodestream_http_requests_total", "counter", "Requests answered, by method, route and status.");
    for (const auto& [key, count] : requests_) {
        const auto& [method, route, status] = key;
        page.sample(
            label("method", method) + "," + label("route", route) + "," + label("status", std::to_string(status)),
            count);
    }
    page.family("lodestream_http_request_duration_seconds", "histogram",
                "Time from a whole request to its answer, by route.");
    for (const auto& [route, latency] : latencies_) {
        const std::string labels = label("route", route);
        for (std::size_t i = 0; i < bucket_limits_s.size(); ++i)
            page.sample(labels + "," + label("le", number(bucket_limits_s[i])), latency.buckets[i], "_bucket");
        page.sample(labels + "," + label("le", "+Inf"), latency.count, "_bucket");
        page.sample(labels, number(latency.sum_s), "_sum");
        page.sample(labels, latency.count, "_count");
    }
    page.family("lodestream_http_response_bytes_total", "counter", "Bytes of the bodies answered, by route.");
    for (const auto& [route, bytes] : bytes_) page.sample(label("route", route), bytes);

    page.family("lodestream_plans_total", "counter", "Plans made, by what limited the budget.");
    for (const auto limit : {budget::LimitedBy::device, budget::LimitedBy::user, budget::LimitedBy::display,
                             budget::LimitedBy::network, budget::LimitedBy::memory, budget::LimitedBy::asset}) {
        const std::string name = budget::limited_by_name(limit);
        const auto it = plans_.find(name);
        page.sample(label("limited_by", name), it == plans_.end() ? 0 : it->second);
    }
    page.family("lodestream_bakes_total", "counter", "Bakes ended since the start, by result.");
    page.sample(label("result", "ready"), bakes.ready);
    page.sample(label("result", "failed"), bakes.failed);
    page.sample(label("result", "cancelled"), bakes.cancelled);
    page.family("lodestream_bakes_waiting", "gauge", "Bakes waiting or running.");
    page.plain(bakes.waiting);
    page.family("lodestream_assets", "gauge", "Assets in the store, by status.");
    for (const auto status : {proto::AssetStatus::baking, proto::AssetStatus::ready, proto::AssetStatus::failed}) {
        std::uint64_t count = 0;
        for (const proto::Asset& asset : assets) count += asset.status == status;
        page.sample(label("status", proto::status_name(status)), count);
    }
    return page.take();
}

}  // namespace lodestream::http
