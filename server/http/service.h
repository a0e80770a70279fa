// Requests to responses, without sockets: what each call of the contract does. Pure but for the store, the planner and
// the bake queue behind it, so tests call it directly.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "proto/messages.h"
#include "server/http/bake_queue.h"
#include "server/live/live_scenes.h"
#include "server/planner/planner.h"
#include "server/store/store.h"

namespace lodestream::http {

// A request as the transport hands it over; header names in lower case.
struct Request {
    std::string method;
    std::string path;  // without the query, percent-decoded
    std::map<std::string, std::string> query;
    std::map<std::string, std::string> headers;
    std::vector<std::byte> body;
};

struct Response {
    int status = 200;
    std::map<std::string, std::string> headers;  // content-type, etag, …
    std::string body;
    std::optional<store::StoredFile> file;  // instead of body: the transport streams [offset, offset+length)
    std::uint64_t file_offset = 0;
    std::uint64_t file_length = 0;
};

inline constexpr std::chrono::seconds max_poll{20};  // that a request for something newer waits

struct ServiceOptions {
    std::string token;  // empty: POST and DELETE of assets are open
};

class Service {
  public:
    Service(store::Store& store, planner::Planner& planner, BakeQueue& bakes, live::LiveScenes& scenes,
            ServiceOptions options);
    ~Service();

    // Never throws; an unexpected failure is a 500 problem.
    Response handle(Request request);

    // What the header alone decides, so that no body is read for it: no such call, wrong method, token, media type.
    std::optional<Response> refuse_early(const Request& head);

    // The answer to bytes that never became a request (malformed, too large, too many); counted like the others.
    Response refuse(int status, const std::string& detail);

    static bool is_heavy(
        const Request& head);  // computes or waits for the disk: not for the threads that serve content
    // A request for a tileset that is newer than what the client has. It is to wait while is_waiting(), max_poll at
    // most; handle() then tells what there is, or that it is no newer.
    struct Poll {
        std::string asset_id;
        std::uint64_t after = 0;  // the revision that the client has
    };
    std::optional<Poll> poll_of(const Request& request) const;
    bool is_waiting(const Poll& poll) const;

    static bool is_upload(const Request& head);  // its body is a model, not JSON

    void stop_accepting();  // /readyz turns 503 while the server drains

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace lodestream::http
