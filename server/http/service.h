// Requests to responses, without sockets: what each call of the contract does. Pure but for the store, the planner and the
// bake queue behind it, so tests call it directly.
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "proto/messages.h"
#include "server/http/bake_queue.h"
#include "server/planner/planner.h"
#include "server/store/store.h"

namespace lodestream::http {

// A request as the transport hands it over; header names in lower case.
struct Request {
    std::string method;
    std::string path;                              // without the query, percent-decoded
    std::map<std::string, std::string> query;
    std::map<std::string, std::string> headers;
    std::vector<std::byte> body;
};

struct Response {
    int status = 200;
    std::map<std::string, std::string> headers;    // content-type, etag, …
    std::string body;
    std::optional<store::StoredFile> file;         // instead of body: the transport streams [offset, offset+length)
    std::uint64_t file_offset = 0;
    std::uint64_t file_length = 0;
};

struct ServiceOptions {
    std::string token;                             // empty: POST and DELETE of assets are open
};

class Service {
  public:
    Service(store::Store& store, planner::Planner& planner, BakeQueue& bakes, ServiceOptions options);

    // Never throws; an unexpected failure is a 500 problem.
    Response handle(const Request& request);

    void stop_accepting();                         // /readyz turns 503 while the server drains

  private:
    store::Store& store_;
    planner::Planner& planner_;
    BakeQueue& bakes_;
    ServiceOptions options_;
    std::atomic<bool> stopping_{false};
};

}  // namespace lodestream::http
