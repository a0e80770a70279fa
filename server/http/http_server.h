// The HTTP face of the service: Boost.Beast over coroutines on N threads.
#pragma once

#include <cstdint>
#include <functional>
#include <stop_token>
#include <string>

#include "common/base/result.h"
#include "server/http/service.h"

namespace lodestream::http {

struct ServerOptions {
    std::string listen = "127.0.0.1:8080";  // HOST:PORT; port 0 takes a free one
    unsigned threads = 0;                   // 0: one a core
    std::uint64_t max_upload_bytes = 512ull << 20;
    std::uint64_t max_json_bytes = 1ull << 20;
    std::uint32_t max_header_bytes = 16u << 10;
    std::uint64_t max_body_bytes_in_flight = 2ull << 30;  // of all requests together
    std::uint32_t max_connections = 4'096;
    std::uint32_t max_waiting_requests = 512;  // plans and uploads; more get 503
    std::uint32_t idle_timeout_s = 30;         // without a byte; for a whole header too
    std::uint32_t max_body_s = 600;            // for a whole body
    std::uint32_t shutdown_grace_s = 10;       // open requests may finish
};

// Serves until `stop` or a signal (SIGINT, SIGTERM; a second one ends the process), then drains: takes no connection,
// lets open requests finish within shutdown_grace_s, closes. `on_listening` gets the bound port. Errors: invalid_input
// (listen), io (address in use, …).
Status serve(Service& service, const ServerOptions& options, const std::function<void(std::uint16_t)>& on_listening,
             std::stop_token stop = {});

}  // namespace lodestream::http
