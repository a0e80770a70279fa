// A client that sends exactly the bytes it is told to.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdint>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>

namespace lodestream::http {

struct RawResponse {
    int status = 0;  // 0: the connection ended before a whole response
    std::map<std::string, std::string> headers;
    std::string body;
};

class RawClient {
  public:
    static constexpr int patience_ms = 120'000;  // for a large upload on a busy machine under a sanitizer

    explicit RawClient(std::uint16_t port) : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port = htons(port);
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        if (::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
            throw std::runtime_error("cannot connect");
    }
    ~RawClient() { ::close(socket_); }
    RawClient(const RawClient&) = delete;
    RawClient& operator=(const RawClient&) = delete;

    // False where the server has closed.
    bool send(std::string_view bytes) {
        while (!bytes.empty()) {
            const ssize_t sent = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
            if (sent <= 0) return false;
            bytes.remove_prefix(static_cast<std::size_t>(sent));
        }
        return true;
    }
    void finish_sending() { ::shutdown(socket_, SHUT_WR); }

    RawResponse receive(bool head_only = false) {
        RawResponse response;
        std::size_t end = 0;
        while ((end = buffer_.find("\r\n\r\n")) == std::string::npos)
            if (!fill()) return response;
        const std::string head = buffer_.substr(0, end + 2);
        buffer_.erase(0, end + 4);
        for (std::size_t at = head.find("\r\n") + 2; at < head.size();) {
            const std::size_t next = head.find("\r\n", at), colon = head.find(": ", at);
            response.headers[head.substr(at, colon - at)] = head.substr(colon + 2, next - colon - 2);
            at = next + 2;
        }
        const int status = std::stoi(head.substr(9, 3));
        const bool no_body = head_only || status == 304 || status == 204 || status == 100;
        const std::size_t length = no_body ? 0 : std::stoull(response.headers.at("content-length"));
        while (buffer_.size() < length)
            if (!fill()) return response;
        response.body = buffer_.substr(0, length);
        buffer_.erase(0, length);
        response.status = status;
        return response;
    }

    // True where the server closes without another byte.
    bool is_closed() { return buffer_.empty() && !fill(); }

  private:
    bool fill() {
        pollfd wait{socket_, POLLIN, 0};
        if (::poll(&wait, 1, patience_ms) != 1) throw std::runtime_error("the server neither answered nor closed");
        char chunk[65536];
        const ssize_t got = ::recv(socket_, chunk, sizeof chunk, 0);
        if (got <= 0) return false;
        buffer_.append(chunk, static_cast<std::size_t>(got));
        return true;
    }

    int socket_;
    std::string buffer_;
};

}  // namespace lodestream::http
