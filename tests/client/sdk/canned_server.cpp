#include "tests/client/sdk/canned_server.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdlib>

namespace lodestream::testing {
namespace {

constexpr int poll_ms = 20;

bool readable(int descriptor) {
    pollfd wait{descriptor, POLLIN, 0};
    return poll(&wait, 1, poll_ms) > 0;
}

std::size_t body_length(const std::string& request) {
    const std::string field = "Content-Length: ";
    const std::size_t at = request.find(field);
    return at == std::string::npos ? 0 : std::strtoull(request.c_str() + at + field.size(), nullptr, 10);
}

bool complete(const std::string& request) {
    const std::size_t end = request.find("\r\n\r\n");
    return end != std::string::npos && request.size() >= end + 4 + body_length(request);
}

void send_all(int connection, const std::string& bytes) {
    std::size_t sent = 0;
    while (sent < bytes.size()) {
        const ssize_t n = send(connection, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
        if (n <= 0) return;
        sent += static_cast<std::size_t>(n);
    }
}

}  // namespace

std::string http_reply(int status, const std::string& content_type, const std::string& body,
                       const std::string& more_headers) {
    return "HTTP/1.1 " + std::to_string(status) + " Reason\r\nContent-Type: " + content_type +
           "\r\nContent-Length: " + std::to_string(body.size()) + "\r\n" + more_headers + "\r\n" + body;
}

CannedServer::CannedServer(std::vector<CannedReply> replies) : replies_(std::move(replies)) {
    listener_ = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    if (bind(listener_, reinterpret_cast<sockaddr*>(&address), size) != 0 || listen(listener_, 8) != 0 ||
        getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size) != 0)
        std::abort();
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this] { serve(); });
}

CannedServer::~CannedServer() {
    stopping_ = true;
    thread_.join();
    close(listener_);
}

std::vector<std::string> CannedServer::requests() const {
    const std::lock_guard lock(mutex_);
    return requests_;
}

void CannedServer::serve() {
    while (!stopping_) {
        if (!readable(listener_)) continue;
        const int connection = accept(listener_, nullptr, nullptr);
        if (connection < 0) continue;
        ++connections_;
        while (answer(connection)) {
        }
        close(connection);
    }
}

bool CannedServer::answer(int connection) {
    std::string request;
    const bool at_once = next_ < replies_.size() && replies_[next_].before_reading;
    while (!complete(request) && !(at_once && !request.empty())) {
        if (stopping_) return false;
        if (!readable(connection)) continue;
        char chunk[4096];
        const ssize_t n = recv(connection, chunk, sizeof chunk, 0);
        if (n <= 0) return false;
        request.append(chunk, static_cast<std::size_t>(n));
    }
    {
        const std::lock_guard lock(mutex_);
        requests_.push_back(request);
    }
    if (next_ >= replies_.size()) return false;
    const CannedReply& reply = replies_[next_++];
    send_all(connection, reply.bytes);
    return !reply.close;
}

}  // namespace lodestream::testing
