#include "server/http/http_server.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <charconv>
#include <chrono>
#include <csignal>
#include <ctime>
#include <optional>
#include <set>
#include <thread>

#include "server/http/asio.h"
#include "server/http/target.h"

namespace lodestream::http {

namespace {

using std::chrono::seconds;

constexpr std::size_t body_chunk_bytes = 64u << 10;    // read at a time
constexpr std::size_t write_chunk_bytes = 256u << 10;  // of a file or a long body, written at a time
constexpr seconds linger{2};  // for a client to read the answer to a request not read to its end
constexpr std::chrono::milliseconds poll_interval{20};  // between two looks for what a request waits for
constexpr seconds accept_pause{1};                      // where no more files can be opened
constexpr std::uint32_t header_slack_bytes = 1024;      // so that the parser's limit is met before the buffer's
constexpr const char* continue_line = "HTTP/1.1 100 Continue\r\n\r\n";

// What all sessions of a server share.
struct Shared {
    Service& service;
    const ServerOptions& options;
    asio::thread_pool& workers;
    std::atomic<std::uint32_t> waiting_requests{0};
    std::atomic<std::uint64_t> body_bytes_in_flight{0};
};

// Adds to a shared count, and takes it back in the end.
template <class T>
class Share {
  public:
    explicit Share(std::atomic<T>& total) : total_(total) {}
    Share(const Share&) = delete;
    Share& operator=(const Share&) = delete;
    ~Share() { total_ -= mine_; }
    bool add(T amount, T most) {
        mine_ += amount;
        return (total_ += amount) <= most;
    }

  private:
    std::atomic<T>& total_;
    T mine_ = 0;
};

std::string http_date() {
    const std::time_t now = std::time(nullptr);
    std::tm utc{};
    gmtime_r(&now, &utc);
    std::array<char, 40> text{};
    const std::size_t length = std::strftime(text.data(), text.size(), "%a, %d %b %Y %H:%M:%S GMT", &utc);
    return {text.data(), length};
}

std::string head_of(const Response& response, std::uint64_t length, bool keep_alive) {
    const auto status = static_cast<beast::http::status>(response.status);
    std::string head = "HTTP/1.1 " + std::to_string(response.status) + " " +
                       std::string(beast::http::obsolete_reason(status)) + "\r\n";
    for (const auto& [name, value] : response.headers) head += name + ": " + value + "\r\n";
    if (response.status != 204 && response.status != 304) head += "content-length: " + std::to_string(length) + "\r\n";
    head += "date: " + http_date() + "\r\n";
    head += keep_alive ? "connection: keep-alive\r\n\r\n" : "connection: close\r\n\r\n";
    return head;
}

// The status of a request that the parser refused; nullopt where the connection failed or ended instead.
std::optional<int> status_of(const beast::error_code& error) {
    using Failure = beast::http::error;
    const beast::error_code ended = Failure::end_of_stream, cut_off = Failure::partial_message;
    if (error.category() != ended.category() || error == ended || error == cut_off) return std::nullopt;
    if (error == Failure::header_limit || error == Failure::buffer_overflow) return 431;
    return error == Failure::bad_version ? 505 : 400;
}

// One connection: requests one after the other, each read whole before it is answered. All its work runs on its own
// strand.
class Session : public std::enable_shared_from_this<Session> {
  public:
    Session(Tcp::socket socket, Shared& shared)
        : shared_(shared), stream_(std::move(socket)), buffer_(shared.options.max_header_bytes + header_slack_bytes) {}

    auto executor() { return stream_.get_executor(); }
    asio::awaitable<void> run();

    // From any thread. stop(): closes when the request under way is answered, at once where there is none.
    void stop();
    void abort();

  private:
    using Parser = beast::http::request_parser<beast::http::buffer_body>;

    asio::awaitable<bool> wait_for_request();
    asio::awaitable<bool> serve_one();
    asio::awaitable<std::optional<Response>> read_body(Parser& parser, Request& request,
                                                       Share<std::uint64_t>& in_flight);
    asio::awaitable<void> wait_for_news(const Request& request);
    asio::awaitable<Response> answer(Request& request);
    asio::awaitable<bool> write(const Response& response, bool head_only, bool keep_alive);
    asio::awaitable<bool> write_file(const Response& response, std::string_view head);
    asio::awaitable<bool> write_bytes(std::string_view head, std::string_view body);
    asio::awaitable<void> refuse_and_close(const Response& response);
    asio::awaitable<void> close_gently();
    void expire_after_idle() { stream_.expires_after(seconds(shared_.options.idle_timeout_s)); }

    Shared& shared_;
    beast::tcp_stream stream_;
    beast::flat_buffer buffer_;
    bool idle_ = false;  // between requests
    bool stopping_ = false;
};

void Session::stop() {
    asio::post(executor(), [self = shared_from_this()] {
        self->stopping_ = true;
        if (self->idle_) self->stream_.close();
    });
}

void Session::abort() {
    asio::post(executor(), [self = shared_from_this()] {
        self->stopping_ = true;
        self->stream_.close();
    });
}

asio::awaitable<void> Session::run() {
    beast::error_code ignored;
    stream_.socket().set_option(Tcp::no_delay(true), ignored);
    while (co_await wait_for_request())
        if (!co_await serve_one()) break;
}

// True when the first bytes of a request are there.
asio::awaitable<bool> Session::wait_for_request() {
    if (stopping_) co_return false;
    if (buffer_.size() > 0) co_return true;
    idle_ = true;
    expire_after_idle();
    const auto [error, count] = co_await stream_.async_read_some(buffer_.prepare(1024), as_values);
    idle_ = false;
    buffer_.commit(count);
    co_return !error && !stopping_;
}

// The request as the service takes it, without its body; or why it cannot be one.
Result<Request> translate(const beast::http::request_header<>& head) {
    auto target = parse_target({head.target().data(), head.target().size()});
    if (!target) return target.error();
    if (head.version() >= 11 && head.find(beast::http::field::host) == head.end())
        return invalid_input("an HTTP/1.1 request needs Host");
    Request request;
    request.method = std::string(head.method_string());
    request.path = std::move(target->path);
    request.query = std::move(target->query);
    for (const auto& field : head) {
        std::string name(field.name_string());
        std::transform(name.begin(), name.end(), name.begin(),
                       [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
        std::string& value = request.headers[name];
        value += (value.empty() ? "" : ", ") + std::string(field.value());
    }
    return request;
}

// False: the connection ends here.
asio::awaitable<bool> Session::serve_one() {
    Parser parser;
    parser.header_limit(shared_.options.max_header_bytes);
    parser.body_limit(boost::none);  // depends on the call; read_body() counts
    expire_after_idle();
    if (const auto [error, count] = co_await beast::http::async_read_header(stream_, buffer_, parser, as_values);
        error) {
        if (const auto status = status_of(error)) {
            const std::string why = *status == 431 ? "the header is longer than " +
                                                         std::to_string(shared_.options.max_header_bytes) + " bytes"
                                                   : "malformed request: " + error.message();
            const Response response = shared_.service.refuse(*status, why);
            co_await refuse_and_close(response);
        }
        co_return false;
    }
    auto request = translate(parser.get());
    if (!request) {
        const Response response = shared_.service.refuse(400, request.error().message);
        co_await refuse_and_close(response);
        co_return false;
    }
    const bool head_only = request->method == "HEAD";
    const bool keep_alive = parser.keep_alive();
    const bool has_body = !parser.is_done();
    std::optional<Response> refused = shared_.service.refuse_early(*request);
    if (!refused && (request->method == "POST" || request->method == "PATCH") && !has_body &&
        !request->headers.contains("content-length") && !parser.chunked())
        refused = shared_.service.refuse(411, "a " + request->method + " needs Content-Length");
    std::optional<Share<std::uint64_t>> in_flight(std::in_place, shared_.body_bytes_in_flight);
    if (!refused && has_body) refused = co_await read_body(parser, *request, *in_flight);
    if (refused && has_body) {
        request->body = {};
        in_flight.reset();
        co_await refuse_and_close(*refused);
        co_return false;
    }
    if (!refused) co_await wait_for_news(*request);
    if (!refused) refused = co_await answer(*request);
    in_flight.reset();  // before the client knows that its body is done with
    const bool written = co_await write(*refused, head_only, keep_alive && !stopping_);
    co_return written&& keep_alive;
}

// Reads the body into `request`; gives the refusal of one that is too large or too slow.
asio::awaitable<std::optional<Response>> Session::read_body(Parser& parser, Request& request,
                                                            Share<std::uint64_t>& in_flight) {
    const ServerOptions& options = shared_.options;
    const std::uint64_t most = Service::is_upload(request) ? options.max_upload_bytes : options.max_json_bytes;
    const std::string too_large = "the body is larger than " + std::to_string(most) + " bytes";
    if (parser.content_length().value_or(0) > most) co_return shared_.service.refuse(413, too_large);
    const auto expect = request.headers.find("expect");
    if (expect != request.headers.end() && beast::iequals(expect->second, "100-continue")) {
        const bool written = co_await write_bytes(continue_line, {});
        if (!written) co_return shared_.service.refuse(400, "the client is gone");
    }
    const auto deadline = std::chrono::steady_clock::now() + seconds(options.max_body_s);
    std::vector<char> chunk(body_chunk_bytes);
    while (!parser.is_done()) {
        parser.get().body().data = chunk.data();
        parser.get().body().size = chunk.size();
        expire_after_idle();
        const auto [error, count] = co_await beast::http::async_read_some(stream_, buffer_, parser, as_values);
        if (error && error != beast::http::error::need_buffer)
            co_return shared_.service.refuse(400, "the body ended early or is malformed: " + error.message());
        const std::size_t got = chunk.size() - parser.get().body().size;
        if (request.body.size() + got > most) co_return shared_.service.refuse(413, too_large);
        if (!in_flight.add(got, options.max_body_bytes_in_flight))
            co_return shared_.service.refuse(503, "too many uploads at once");
        if (std::chrono::steady_clock::now() > deadline)
            co_return shared_.service.refuse(408,
                                             "the body took longer than " + std::to_string(options.max_body_s) + " s");
        const auto* bytes = reinterpret_cast<const std::byte*>(chunk.data());
        request.body.insert(request.body.end(), bytes, bytes + got);
    }
    co_return std::nullopt;
}

// Holds no thread while it waits.
asio::awaitable<void> Session::wait_for_news(const Request& request) {
    const std::optional<Service::Poll> poll = shared_.service.poll_of(request);
    const auto end = std::chrono::steady_clock::now() + max_poll;
    asio::steady_timer pause(executor());
    while (poll && !stopping_ && shared_.service.is_waiting(*poll) && std::chrono::steady_clock::now() < end) {
        pause.expires_after(poll_interval);
        co_await pause.async_wait(as_values);
    }
}

// Heavy calls go to the workers, so that the threads of the sockets stay free for content.
asio::awaitable<Response> Session::answer(Request& request) {
    Service& service = shared_.service;
    if (!Service::is_heavy(request)) co_return service.handle(std::move(request));
    Share<std::uint32_t> waiting(shared_.waiting_requests);
    if (!waiting.add(1, shared_.options.max_waiting_requests))
        co_return service.refuse(
            503, "more than " + std::to_string(shared_.options.max_waiting_requests) + " requests wait already");
    const auto work = [&service, &request]() -> asio::awaitable<Response> {
        co_return service.handle(std::move(request));
    };
    Response response = co_await asio::co_spawn(shared_.workers, work, asio::use_awaitable);
    co_return response;
}

asio::awaitable<bool> Session::write(const Response& response, bool head_only, bool keep_alive) {
    const std::uint64_t length = response.file ? response.file_length : response.body.size();
    const std::string head = head_of(response, length, keep_alive);
    bool written = false;
    if (head_only)
        written = co_await write_bytes(head, {});
    else if (response.file)
        written = co_await write_file(response, head);
    else
        written = co_await write_bytes(head, response.body);
    co_return written;
}

asio::awaitable<bool> Session::write_bytes(std::string_view head, std::string_view body) {
    do {
        const std::string_view part = body.substr(0, write_chunk_bytes);
        body.remove_prefix(part.size());
        const std::array<asio::const_buffer, 2> buffers{asio::buffer(head), asio::buffer(part)};
        head = {};
        expire_after_idle();
        const auto [error, count] = co_await asio::async_write(stream_, buffers, as_values);
        if (error) co_return false;
    } while (!body.empty());
    co_return true;
}

// Streams a part of a file; the first chunk goes out with the head.
asio::awaitable<bool> Session::write_file(const Response& response, std::string_view head) {
    beast::error_code error;
    beast::file file;
    file.open(response.file->path.c_str(), beast::file_mode::scan, error);
    if (!error) file.seek(response.file_offset, error);
    if (error) {  // removed since it was looked up
        const Response removed = shared_.service.refuse(404, "this content has just been removed");
        const std::string other_head = head_of(removed, removed.body.size(), false);
        co_await write_bytes(other_head, removed.body);
        co_return false;
    }
    std::string chunk;
    for (std::uint64_t left = response.file_length; left > 0 || !head.empty();) {
        chunk.resize(std::min<std::uint64_t>(left, write_chunk_bytes));
        for (std::size_t filled = 0; filled < chunk.size();) {
            const std::size_t got = file.read(chunk.data() + filled, chunk.size() - filled, error);
            if (error || got == 0) co_return false;
            filled += got;
        }
        left -= chunk.size();
        const bool written = co_await write_bytes(head, chunk);
        if (!written) co_return false;
        head = {};
    }
    co_return true;
}

// Answers a request that has not been read to its end.
asio::awaitable<void> Session::refuse_and_close(const Response& response) {
    const bool written = co_await write(response, false, false);
    if (written) co_await close_gently();
}

// Reads what the client still sends for a while: closing at once would reset the connection under the answer.
asio::awaitable<void> Session::close_gently() {
    beast::error_code error;
    stream_.socket().shutdown(Tcp::socket::shutdown_send, error);
    std::vector<char> waste(body_chunk_bytes);
    stream_.expires_after(linger);
    while (!error) {
        const auto [read_error, count] = co_await stream_.async_read_some(asio::buffer(waste), as_values);
        error = read_error;
    }
}

// Accepts, keeps the sessions and ends them. Its own state is touched on its strand alone.
class Server {
  public:
    Server(Service& service, const ServerOptions& options, unsigned threads)
        : io_(static_cast<int>(threads)),
          workers_(threads),
          shared_{service, options, workers_},
          strand_(asio::make_strand(io_)),
          acceptor_(strand_),
          signals_(strand_),
          grace_(strand_) {}

    Result<std::uint16_t> listen();
    void run(unsigned threads, const std::stop_token& stop);

  private:
    asio::awaitable<void> accept_sessions();
    void start(Tcp::socket socket);
    void begin_stop();
    void end_if_drained();

    asio::io_context io_;
    asio::thread_pool workers_;
    Shared shared_;
    asio::strand<asio::io_context::executor_type> strand_;
    Tcp::acceptor acceptor_;
    asio::signal_set signals_;
    asio::steady_timer grace_;
    std::set<std::shared_ptr<Session>> sessions_;
    bool stopping_ = false;
};

Result<Tcp::endpoint> resolve(asio::io_context& io, const std::string& listen) {
    const auto colon = listen.rfind(':');
    if (colon == std::string::npos || colon == 0)
        return invalid_input("cannot listen on \"" + listen + "\": it must be HOST:PORT");
    std::string host = listen.substr(0, colon);
    if (host.size() > 2 && host.front() == '[' && host.back() == ']') host = host.substr(1, host.size() - 2);
    const std::string port = listen.substr(colon + 1);
    std::uint16_t number = 0;
    const auto [end, wrong] = std::from_chars(port.data(), port.data() + port.size(), number);
    if (port.empty() || wrong != std::errc() || end != port.data() + port.size())
        return invalid_input("cannot listen on \"" + listen + "\": the port must be a number up to 65535");
    beast::error_code error;
    const auto found = Tcp::resolver(io).resolve(host, port, Tcp::resolver::passive, error);
    if (error || found.empty()) return invalid_input("cannot listen on \"" + listen + "\": " + error.message());
    return found.begin()->endpoint();
}

Result<std::uint16_t> Server::listen() {
    const auto endpoint = resolve(io_, shared_.options.listen);
    if (!endpoint) return endpoint.error();
    beast::error_code error;
    acceptor_.open(endpoint->protocol(), error);
    if (!error) acceptor_.set_option(asio::socket_base::reuse_address(true), error);
    if (!error) acceptor_.bind(*endpoint, error);
    if (!error) acceptor_.listen(asio::socket_base::max_listen_connections, error);
    if (error) return fail(ErrorCode::io, "cannot listen on " + shared_.options.listen + ": " + error.message());
    return acceptor_.local_endpoint().port();
}

asio::awaitable<void> Server::accept_sessions() {
    while (acceptor_.is_open()) {
        auto [error, socket] = co_await acceptor_.async_accept(asio::make_strand(io_), as_values);
        if (!error) {
            start(Tcp::socket(std::move(socket)));
        } else if (acceptor_.is_open()) {
            asio::steady_timer pause(strand_, accept_pause);
            co_await pause.async_wait(as_values);
        }
    }
}

void Server::start(Tcp::socket socket) {
    if (stopping_ || sessions_.size() >= shared_.options.max_connections) return;  // closes the socket
    const auto session = std::make_shared<Session>(std::move(socket), shared_);
    sessions_.insert(session);
    asio::co_spawn(session->executor(), session->run(), [this, session](const std::exception_ptr&) {
        asio::post(strand_, [this, session] {
            sessions_.erase(session);
            end_if_drained();
        });
    });
}

void Server::begin_stop() {
    if (stopping_) return;
    stopping_ = true;
    shared_.service.stop_accepting();
    beast::error_code ignored;
    signals_.clear(ignored);  // a second signal ends the process
    signals_.cancel(ignored);
    acceptor_.close(ignored);
    for (const auto& session : sessions_) session->stop();
    grace_.expires_after(seconds(shared_.options.shutdown_grace_s));
    grace_.async_wait([this](const beast::error_code& error) {
        if (error) return;
        for (const auto& session : sessions_) session->abort();
    });
    end_if_drained();
}

void Server::end_if_drained() {
    if (stopping_ && sessions_.empty()) grace_.cancel();
}

void Server::run(unsigned threads, const std::stop_token& stop) {
    signals_.add(SIGINT);
    signals_.add(SIGTERM);
    signals_.async_wait([this](const beast::error_code& error, int) {
        if (!error) begin_stop();
    });
    asio::co_spawn(strand_, accept_sessions(), asio::detached);
    const std::stop_callback stopper(stop, [this] { asio::post(strand_, [this] { begin_stop(); }); });
    std::vector<std::jthread> others;
    for (unsigned i = 1; i < threads; ++i) others.emplace_back([this] { io_.run(); });
    io_.run();
    others.clear();
    workers_.join();
}

}  // namespace

Status serve(Service& service, const ServerOptions& options, const std::function<void(std::uint16_t)>& on_listening,
             std::stop_token stop) try {
    const unsigned threads = options.threads ? options.threads : std::max(1u, std::thread::hardware_concurrency());
    Server server(service, options, threads);
    const auto port = server.listen();
    if (!port) return port.error();
    if (on_listening) on_listening(*port);
    server.run(threads, stop);
    return Nothing{};
} catch (const std::exception& e) {
    return fail(ErrorCode::io, std::string("the server failed: ") + e.what());
}

}  // namespace lodestream::http
