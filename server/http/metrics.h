// The service's figures in Prometheus' text format 0.0.4. Private to http. All calls may come from any thread.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "proto/messages.h"
#include "server/http/bake_queue.h"

namespace lodestream::http {

class Metrics {
  public:
    // `route` and `method` must be of a bounded set: each pair is kept for ever.
    void count_request(std::string_view method, std::string_view route, int status, double seconds,
                       std::uint64_t bytes);
    void count_plan(const std::string& limited_by);

    std::string text(const BakeQueue::Counts& bakes, const std::vector<proto::Asset>& assets) const;

  private:
    static constexpr std::array<double, 12> bucket_limits_s{0.0005, 0.001, 0.0025, 0.005, 0.01, 0.025,
                                                            0.05,   0.1,   0.25,   1.0,   2.5,  10.0};

    struct Latency {
        std::array<std::uint64_t, bucket_limits_s.size()> buckets{};
        std::uint64_t count = 0;
        double sum_s = 0.0;
    };

    mutable std::mutex mutex_;
    std::map<std::tuple<std::string, std::string, int>, std::uint64_t> requests_;  // method, route, status
    std::map<std::string, Latency> latencies_;                                     // route
    std::map<std::string, std::uint64_t> bytes_;                                   // route
    std::map<std::string, std::uint64_t> plans_;                                   // limited_by
};

}  // namespace lodestream::http
