#include "client/sdk/http_connection.h"

#include <utility>
// Asio of Boost 1.81 needs <utility> before it with g++ 12.
#include <algorithm>
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <chrono>
#include <optional>

#include "proto/gzip.h"

namespace lodestream::sdk {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using boost::system::error_code;
using Clock = std::chrono::steady_clock;

constexpr int http_1_1 = 11;

constexpr double late_waking_s = 5e-3;

Clock::duration seconds(double s) {
    return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(s));
}

Clock::time_point deadline_after(double after_s) {
    return Clock::now() + seconds(after_s);
}

std::string authority(const ServerUrl& server) {
    const bool ipv6 = server.host.find(':') != std::string::npos;
    return (ipv6 ? "[" + server.host + "]" : server.host) + ":" + std::to_string(server.port);
}

}  // namespace

// Beast has deadlines for asynchronous operations alone, so each one is started and run to its end.
struct HttpConnection::Impl {
    ServerUrl server;
    std::optional<Link> link;
    asio::io_context io;
    std::optional<beast::tcp_stream> stream;
    beast::flat_buffer buffer;
    std::atomic<bool> is_cancelled{false};

    using RequestMessage = http::request<http::span_body<const std::byte>>;
    using ResponseParser = http::response_parser<http::string_body>;

    Impl(ServerUrl url, std::optional<Link> tried) : server(std::move(url)), link(tried) {}

    template <class Start>
    error_code run(Start start) {
        error_code result;
        if (is_cancelled) return asio::error::operation_aborted;
        start([&result](error_code error, auto&&...) { result = error; });
        io.restart();
        io.run();
        return result;
    }

    // Whatever runs is told by its own thread; what starts later sees the flag.
    void cancel() {
        is_cancelled = true;
        asio::post(io, [this] {
            if (stream) stream->cancel();
        });
    }

    void close() {
        stream.reset();
        buffer.clear();
    }

    error_code connect() {
        close();
        error_code error;
        asio::ip::tcp::resolver resolver(io);
        const auto endpoints = resolver.resolve(server.host, std::to_string(server.port), error);
        if (error) return error;
        stream.emplace(io);
        stream->expires_at(deadline_after(connect_timeout_s));
        error = run([&](auto done) { stream->async_connect(endpoints, done); });
        if (error) return error;
        error_code ignored;
        if (link) wait_until(Clock::now() + seconds(1e-3 * link->rtt_ms));
        stream->socket().set_option(asio::ip::tcp::no_delay(true), ignored);
        return error;
    }

    RequestMessage message(const HttpRequest& request) const {
        RequestMessage out;
        out.version(http_1_1);
        out.method_string(request.method);
        out.target(request.target);
        out.set(http::field::host, authority(server));
        out.set(http::field::user_agent, "lodestream-client");
        out.set(http::field::accept, "*/*");
        out.set(http::field::accept_encoding, "gzip");
        if (!request.token.empty()) out.set(http::field::authorization, "Bearer " + request.token);
        if (!request.content_type.empty()) {
            out.set(http::field::content_type, request.content_type);
            out.body() = beast::span<const std::byte>(request.body.data(), request.body.size());
            out.content_length(request.body.size());
        }
        return out;
    }

    // A server that refuses a body early answers and closes while the body is still on its way: its answer counts.
    error_code exchange_once(RequestMessage& request, ResponseParser& parser) {
        if (link) wait_until(Clock::now() + seconds(1e-3 * link->rtt_ms));
        stream->expires_at(deadline_after(request_timeout_s));
        const error_code written = run([&](auto done) { http::async_write(*stream, request, done); });
        const error_code read = link && link->downlink_mbps > 0.0
                                    ? read_slowly(parser)
                                    : run([&](auto done) { http::async_read(*stream, buffer, parser, done); });
        return read && written ? written : read;
    }

    // A byte counts as arrived when the link has carried those before it; a late waking is made up for.
    error_code read_slowly(ResponseParser& parser) {
        const double bytes_per_s = 1e6 / 8.0 * link->downlink_mbps;
        Clock::time_point arrived{};
        while (!parser.is_done()) {
            std::size_t bytes = 0;
            const error_code error = run([&](auto done) {
                http::async_read_some(*stream, buffer, parser, [&bytes, done](error_code failed, std::size_t read) {
                    bytes = read;
                    done(failed);
                });
            });
            if (error) return error;
            arrived = std::max(arrived, Clock::now() - seconds(late_waking_s));
            arrived += seconds(static_cast<double>(bytes) / bytes_per_s);
            wait_until(arrived);
        }
        return {};
    }

    void wait_until(Clock::time_point then) {
        asio::steady_timer timer(io, then);
        run([&](auto done) { timer.async_wait(done); });
    }

    std::string where(const HttpRequest& request) const {
        return request.method + " " + request.target + " at " + authority(server) + ": ";
    }

    Error describe(const HttpRequest& request, error_code error) const {
        if (is_cancelled) return fail(ErrorCode::unavailable, where(request) + "cancelled");
        if (error == http::error::body_limit)
            return fail(ErrorCode::limit_exceeded, where(request) + "the response is larger than expected");
        if (error == http::error::end_of_stream || error == http::error::partial_message)
            return fail(ErrorCode::io,
                        where(request) + "the server closed the connection before the response was complete");
        if (error == beast::error::timeout) return fail(ErrorCode::io, where(request) + "timed out");
        return fail(ErrorCode::io, where(request) + error.message());
    }

    Result<HttpResponse> exchange(const HttpRequest& request, std::uint64_t max_body_bytes) {
        RequestMessage out = message(request);
        bool reused = stream && request.repeatable;
        for (;;) {
            if (!reused)
                if (const error_code error = connect())
                    return fail(ErrorCode::unavailable,
                                "cannot connect to " + authority(server) + ": " + error.message());
            ResponseParser parser;
            parser.header_limit(max_header_bytes);
            parser.body_limit(max_body_bytes);
            const error_code error = exchange_once(out, parser);
            if (error) {
                close();
                if (reused && !parser.got_some()) {
                    reused = false;
                    continue;
                }
                return describe(request, error);
            }
            if (!parser.keep_alive()) close();
            auto response = parser.release();
            if (beast::iequals(response[http::field::content_encoding], "gzip")) {
                Result<std::string> body = proto::gunzip(response.body(), max_body_bytes);
                if (!body) return fail(body.error().code, where(request) + body.error().message);
                response.body() = *std::move(body);
            }
            return HttpResponse{static_cast<int>(response.result_int()),
                                std::string(response[http::field::content_type]), std::move(response.body())};
        }
    }
};

HttpConnection::HttpConnection(ServerUrl server, std::optional<Link> link)
    : impl_(std::make_unique<Impl>(std::move(server), link)) {}
HttpConnection::~HttpConnection() = default;

void HttpConnection::cancel() {
    impl_->cancel();
}

Result<HttpResponse> HttpConnection::exchange(const HttpRequest& request, std::uint64_t max_body_bytes) {
    try {
        return impl_->exchange(request, max_body_bytes);
    } catch (const std::exception& error) {
        impl_->close();
        return fail(ErrorCode::io, request.method + " " + request.target + ": " + error.what());
    }
}

}  // namespace lodestream::sdk
