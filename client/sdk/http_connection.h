// One kept-alive HTTP/1.1 connection with deadlines and size limits; private to this folder.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "client/sdk/client.h"

namespace lodestream::sdk {

struct HttpRequest {
    std::string method = "GET";
    std::string target;        // path and query, percent-encoded
    std::string content_type;  // of the body; empty: no body
    std::span<const std::byte> body;
    std::string token;       // sent as a bearer token; empty: none
    bool repeatable = true;  // may be sent again where a reused connection turns out to be dead
};

struct HttpResponse {
    int status = 0;
    std::string content_type;
    std::string body;
};

class HttpConnection {
  public:
    explicit HttpConnection(ServerUrl server, std::optional<Link> link = {});
    ~HttpConnection();

    // Bodies may come as gzip. Errors: unavailable (no connection, cancelled), limit_exceeded (body over
    // max_body_bytes, as it came or unpacked), invalid_input (no sound gzip), io (everything else that goes wrong on
    // the way). Any complete response is a success, whatever its status.
    Result<HttpResponse> exchange(const HttpRequest& request, std::uint64_t max_body_bytes);

    void cancel();  // from any thread; for good

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace lodestream::sdk
