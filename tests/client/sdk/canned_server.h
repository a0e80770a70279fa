// A TCP server that answers each request with the next of its canned byte strings, however wrong they are.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace lodestream::testing {

struct CannedReply {
    std::string bytes;
    bool close = false;           // the connection, after the bytes
    bool before_reading = false;  // sent at once, then the request is not read to its end
};

// "HTTP/1.1 STATUS …" with a right Content-Length.
std::string http_reply(int status, const std::string& content_type, const std::string& body,
                       const std::string& more_headers = {});

class CannedServer {
  public:
    explicit CannedServer(std::vector<CannedReply> replies);
    ~CannedServer();  // closes every connection

    std::string url() const { return "http://127.0.0.1:" + std::to_string(port_); }
    std::vector<std::string> requests() const;  // whole, header and body
    int connections() const { return connections_; }

  private:
    void serve();
    bool answer(int connection);  // false: the connection is over

    std::vector<CannedReply> replies_;
    std::size_t next_ = 0;
    int listener_ = -1;
    std::uint16_t port_ = 0;
    std::atomic<int> connections_{0};
    std::atomic<bool> stopping_{false};
    mutable std::mutex mutex_;
    std::vector<std::string> requests_;
    std::thread thread_;
};

}  // namespace lodestream::testing
