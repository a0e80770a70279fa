#include "server/http/http_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <csignal>
#include <fstream>
#include <future>
#include <latch>
#include <memory>
#include <thread>

#include "tests/server/http/harness.h"
#include "tests/server/http/raw_client.h"

namespace lodestream::http {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::StartsWith;

// A server on a free port of the loopback, for as long as the object lives.
class RunningServer {
  public:
    explicit RunningServer(ServerOptions options = {}, ServiceOptions service_options = {})
        : harness(std::move(service_options)) {
        options.listen = "127.0.0.1:0";
        if (options.threads == 0) options.threads = 2;
        std::promise<std::uint16_t> bound;
        auto port_future = bound.get_future();
        done_ = std::async(std::launch::async, [this, options, &bound] {
            return serve(
                       harness.service, options, [&](std::uint16_t p) { bound.set_value(p); }, stop_.get_token())
                .ok();
        });
        port = port_future.get();
    }
    ~RunningServer() { stop_.request_stop(); }

    void stop() { stop_.request_stop(); }
    bool wait() { return done_.get(); }
    bool has_ended() { return done_.wait_for(std::chrono::seconds(0)) == std::future_status::ready; }

    // One whole exchange on a connection of its own.
    RawResponse exchange(const std::string& bytes, bool head_only = false) {
        RawClient client(port);
        client.send(bytes);
        return client.receive(head_only);
    }

    Harness harness;
    std::uint16_t port = 0;

  private:
    std::stop_source stop_;
    std::future<bool> done_;
};

std::string request(const std::string& method, const std::string& target, const std::string& fields = {}) {
    return method + " " + target + " HTTP/1.1\r\nHost: test\r\n" + fields + "\r\n";
}
std::string request_with_body(const std::string& target, const std::string& body, const std::string& fields = {}) {
    return request("POST", target, "Content-Length: " + std::to_string(body.size()) + "\r\n" + fields) + body;
}

// A stored content that no bake made, of `size` known bytes.
std::string put_content(Harness& harness, std::size_t size, std::string& bytes) {
    proto::Asset asset;
    asset.id = asset.name = "content";
    asset.kind = "mesh";
    static_cast<void>(harness.store.put_asset(asset));
    bytes.resize(size);
    for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<char>(i * 31 + i / 251);
    const auto file = harness.store.put_content("content", "level", "glb", std::as_bytes(std::span(bytes)));
    return "/v1/content/" + file.value().hash + ".glb";
}

TEST(HttpServer, AnswersAndKeepsTheConnection) {
    RunningServer server;
    RawClient client(server.port);
    for (int i = 0; i < 3; ++i) {
        ASSERT_TRUE(client.send(request("GET", "/livez")));
        const RawResponse response = client.receive();
        EXPECT_EQ(response.status, 200);
        EXPECT_EQ(response.body, "ok\n");
        EXPECT_EQ(response.headers.at("connection"), "keep-alive");
        EXPECT_THAT(response.headers.at("date"), HasSubstr(" GMT"));
    }
    client.send(request("GET", "/livez", "Connection: close\r\n"));
    EXPECT_EQ(client.receive().headers.at("connection"), "close");
    EXPECT_TRUE(client.is_closed());
}

TEST(HttpServer, ClosesAfterAnOldClientsRequest) {
    RunningServer server;
    RawClient client(server.port);
    client.send("GET /livez HTTP/1.0\r\n\r\n");
    EXPECT_EQ(client.receive().status, 200);
    EXPECT_TRUE(client.is_closed());
}

TEST(HttpServer, AnswersPipelinedRequestsInTheirOrder) {
    RunningServer server;
    RawClient client(server.port);
    client.send(request("GET", "/livez") + request("GET", "/nowhere") + request("HEAD", "/livez") +
                request_with_body("/v1/plans", "{") + request("GET", "/livez"));
    EXPECT_EQ(client.receive().status, 200);
    EXPECT_EQ(client.receive().status, 404);
    EXPECT_EQ(client.receive(true).status, 200);
    EXPECT_EQ(client.receive().status, 400);
    EXPECT_EQ(client.receive().body, "ok\n");
}

TEST(HttpServer, AnswersAClientThatHasStoppedSending) {
    RunningServer server;
    RawClient client(server.port);
    client.send(request("GET", "/livez") + request("GET", "/openapi.json"));
    client.finish_sending();
    EXPECT_EQ(client.receive().status, 200);
    EXPECT_EQ(client.receive().status, 200);
    EXPECT_TRUE(client.is_closed());
}

TEST(HttpServer, TakesARequestByteByByte) {
    RunningServer server;
    RawClient client(server.port);
    for (const char c : request_with_body("/v1/plans", "{}")) ASSERT_TRUE(client.send({&c, 1}));
    const RawResponse response = client.receive();
    EXPECT_EQ(response.status, 400);
    EXPECT_THAT(response.body, HasSubstr("asset is missing"));
}

TEST(HttpServer, TakesAChunkedBody) {
    RunningServer server;
    RawClient client(server.port);
    client.send(request("POST", "/v1/plans", "Transfer-Encoding: chunked\r\n") +
                "3\r\n{\"a\r\n5\r\n\":1}\n\r\n0\r\n\r\n");
    EXPECT_THAT(client.receive().body, HasSubstr("asset is missing"));
    client.send(request("GET", "/livez"));
    EXPECT_EQ(client.receive().status, 200);
}

TEST(HttpServer, RefusesMalformedRequests) {
    RunningServer server;
    const std::string host = "Host: test\r\n\r\n";
    for (const std::string& bytes :
         {std::string("nonsense\r\n\r\n"), "GET\r\n" + host, "G@T / HTTP/1.1\r\n" + host,
          std::string("GET / HTTP/1.1\r\nNo colon here\r\n\r\n"), std::string("GET / HTTP/1.1\r\n\r\n"),
          "GET /%zz HTTP/1.1\r\n" + host, "GET /%00 HTTP/1.1\r\n" + host, "GET relative HTTP/1.1\r\n" + host,
          request("POST", "/v1/plans", "Content-Length: -1\r\n"),
          request("POST", "/v1/plans", "Content-Length: 1\r\nContent-Length: 2\r\n"),
          request("POST", "/v1/plans", "Content-Length: 1\r\nTransfer-Encoding: chunked\r\n"),
          request("POST", "/v1/plans", "Transfer-Encoding: chunked\r\n") + "zz\r\n",
          std::string("\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03", 11) + std::string(50, '\x01')}) {
        const RawResponse response = server.exchange(bytes);
        EXPECT_EQ(response.status, 400) << bytes;
        ASSERT_FALSE(response.body.empty()) << bytes;
        EXPECT_EQ(response.headers.at("content-type"), "application/problem+json");
        EXPECT_EQ(response.headers.at("connection"), "close");
    }
    EXPECT_EQ(server.exchange("GET / HTTP/2.0\r\n" + host).status, 505);
    EXPECT_EQ(server.exchange("GET / HTTP/1.1 extra\r\n" + host).status, 505);
    EXPECT_EQ(server.exchange(request("GET", "/livez")).status, 200);
}

TEST(HttpServer, RefusesAPostWithoutALength) {
    RunningServer server;
    RawClient client(server.port);
    client.send(request("POST", "/v1/plans"));
    EXPECT_EQ(client.receive().status, 411);
    client.send(request("POST", "/v1/plans", "Content-Length: 0\r\n"));
    EXPECT_EQ(client.receive().status, 400);
}

TEST(HttpServer, BoundsTheHeader) {
    RunningServer server;
    const std::string big(server.harness.call("GET", "/").body.size() + 20'000, 'x');
    for (const std::string& bytes :
         {request("GET", "/livez", "X-Big: " + big + "\r\n"), request("GET", "/" + big), std::string(100'000, 'A')}) {
        const RawResponse response = server.exchange(bytes);
        EXPECT_TRUE(response.status == 431 || (bytes[0] == 'A' && response.status == 400)) << response.status;
        EXPECT_TRUE(json::accept(response.body));
    }
    const std::string fits(15'000, 'x');
    EXPECT_EQ(server.exchange(request("GET", "/livez", "X-Big: " + fits + "\r\n")).status, 200);
}

TEST(HttpServer, BoundsTheBodyOfEachCall) {
    ServerOptions options;
    options.max_json_bytes = 1000;
    options.max_upload_bytes = 100'000;
    RunningServer server(options);
    EXPECT_EQ(server.exchange(request_with_body("/v1/plans", std::string(1000, ' '))).status, 400);
    EXPECT_EQ(server.exchange(request_with_body("/v1/plans", std::string(1001, ' '))).status, 413);
    EXPECT_EQ(server.exchange(request_with_body("/v1/assets?name=x", std::string(100'000, ' '))).status, 415);
    EXPECT_EQ(server.exchange(request_with_body("/v1/assets?name=x", std::string(100'001, ' '))).status, 413);
    EXPECT_EQ(server.exchange(request("POST", "/v1/plans", "Content-Length: 18446744073709551615\r\n")).status, 413);
    RawClient chunked(server.port);
    chunked.send(request("POST", "/v1/plans", "Transfer-Encoding: chunked\r\n"));
    for (int i = 0; i < 10; ++i) chunked.send("80\r\n" + std::string(128, ' ') + "\r\n");
    EXPECT_EQ(chunked.receive().status, 413);
}

TEST(HttpServer, BoundsTheBytesInFlightAndGivesThemBackAtOnce) {
    ServerOptions options;
    options.max_body_bytes_in_flight = 10'000;
    RunningServer server(options);
    const auto upload = [&](std::size_t bytes, RawClient& client) {
        client.send(request_with_body("/v1/assets?name=x", std::string(bytes, ' ')));
        return client.receive();
    };
    std::vector<std::unique_ptr<RawClient>> kept_open;  // so that a refused one lingers
    for (int round = 0; round < 5; ++round) {
        for (const auto& [bytes, status] : {std::pair{6'000, 415}, {10'001, 503}, {10'000, 415}}) {
            kept_open.push_back(std::make_unique<RawClient>(server.port));
            const RawResponse response = upload(static_cast<std::size_t>(bytes), *kept_open.back());
            EXPECT_EQ(response.status, status) << bytes << " bytes in round " << round;
            EXPECT_EQ(response.headers.contains("retry-after"), status == 503);
        }
    }
}

TEST(HttpServer, AnswersBeforeAnUnwantedBodyIsSent) {
    RunningServer server({}, {"s3cret"});
    RawClient client(server.port);
    client.send(request("POST", "/v1/assets?name=x", "Content-Length: 400000000\r\nExpect: 100-continue\r\n"));
    EXPECT_EQ(client.receive().status, 401);
    EXPECT_TRUE(client.is_closed());
    RawClient pushy(server.port);
    pushy.send(request("POST", "/v1/assets?name=x", "Content-Length: 4000000\r\n") + std::string(4'000'000, 'x'));
    EXPECT_EQ(pushy.receive().status, 401);
}

TEST(HttpServer, TellsAClientToContinue) {
    RunningServer server;
    RawClient client(server.port);
    client.send(request("POST", "/v1/plans", "Content-Length: 2\r\nExpect: 100-continue\r\n"));
    EXPECT_EQ(client.receive().status, 100);
    client.send("{}");
    EXPECT_EQ(client.receive().status, 400);
}

TEST(HttpServer, DropsSlowAndSilentClients) {
    ServerOptions options;
    options.idle_timeout_s = 1;
    RunningServer server(options);
    RawClient silent(server.port), slow_header(server.port), slow_body(server.port);
    slow_header.send("GET /livez HTTP/1.1\r\nHost: te");
    slow_body.send(request("POST", "/v1/plans", "Content-Length: 10\r\n") + "{");
    EXPECT_TRUE(silent.is_closed());
    EXPECT_TRUE(slow_header.is_closed());
    EXPECT_NE(slow_body.receive().status, 200);
    EXPECT_EQ(server.exchange(request("GET", "/livez")).status, 200);
}

TEST(HttpServer, AHeaderSentByteByByteHasOneDeadline) {
    ServerOptions options;
    options.idle_timeout_s = 1;
    RunningServer server(options);
    RawClient client(server.port);
    client.send("GET /livez HTTP/1.1\r\n");
    const auto start = std::chrono::steady_clock::now();
    while (client.send("X: y\r\n") && std::chrono::steady_clock::now() - start < std::chrono::seconds(15))
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(15));
}

TEST(HttpServer, StreamsContentWholeAndInParts) {
    RunningServer server;
    std::string bytes;
    const std::string url = put_content(server.harness, 1'000'003, bytes);
    RawClient client(server.port);
    client.send(request("GET", url));
    const RawResponse whole = client.receive();
    EXPECT_EQ(whole.status, 200);
    EXPECT_TRUE(whole.body == bytes);
    client.send(request("GET", url, "Range: bytes=262140-524300\r\n"));
    const RawResponse part = client.receive();
    EXPECT_EQ(part.status, 206);
    EXPECT_EQ(part.headers.at("content-range"), "bytes 262140-524300/1000003");
    EXPECT_TRUE(part.body == bytes.substr(262140, 524300 - 262140 + 1));
    client.send(request("GET", url, "Range: bytes=-3\r\n"));
    EXPECT_EQ(client.receive().body, bytes.substr(1'000'000));
    client.send(request("GET", url, "Range: bytes=1000003-\r\n"));
    EXPECT_EQ(client.receive().status, 416);
    client.send(request("GET", url, "If-None-Match: " + whole.headers.at("etag") + "\r\n"));
    const RawResponse unchanged = client.receive();
    EXPECT_EQ(unchanged.status, 304);
    EXPECT_FALSE(unchanged.headers.contains("content-length"));
    client.send(request("HEAD", url));
    const RawResponse head = client.receive(true);
    EXPECT_EQ(head.status, 200);
    EXPECT_EQ(head.headers.at("content-length"), "1000003");
    EXPECT_EQ(head.headers.at("etag"), whole.headers.at("etag"));
    client.send(request("GET", "/livez"));
    EXPECT_EQ(client.receive().body, "ok\n");
}

TEST(HttpServer, StreamsEmptyContent) {
    RunningServer server;
    std::string bytes;
    const RawResponse response = server.exchange(request("GET", put_content(server.harness, 0, bytes)));
    EXPECT_EQ(response.status, 200);
    EXPECT_EQ(response.headers.at("content-length"), "0");
}

TEST(HttpServer, ContentStaysWholeWhileItsAssetIsRemoved) {
    RunningServer server;
    std::string bytes;
    const std::string url = put_content(server.harness, 8'000'000, bytes);
    RawClient client(server.port);
    client.send(request("GET", url));
    while (server.exchange(request("DELETE", "/v1/assets/content")).status == 0) {
    }
    const RawResponse response = client.receive();
    EXPECT_TRUE((response.status == 200 && response.body == bytes) || response.status == 404);
    EXPECT_EQ(server.exchange(request("GET", url)).status, 404);
}

TEST(HttpServer, ServesManyConnectionsAtOnce) {
    RunningServer server;
    server.harness.bake("teapot");
    std::string bytes;
    const std::string url = put_content(server.harness, 300'000, bytes);
    const std::string plan = R"({"asset":"teapot","device":{"cpu_mhz":300},"reference":{"triangles":2000}})";
    constexpr int connections = 50, rounds = 5;
    std::latch together(connections);
    std::vector<std::future<int>> clients;
    for (int i = 0; i < connections; ++i)
        clients.push_back(std::async(std::launch::async, [&] {
            RawClient client(server.port);
            together.arrive_and_wait();
            int good = 0;
            for (int round = 0; round < rounds; ++round) {
                client.send(request("GET", url));
                good += client.receive().body == bytes;
                client.send(request_with_body("/v1/plans", plan));
                good += client.receive().status == 200;
                client.send(request("GET", "/v1/assets"));
                good += client.receive().status == 200;
            }
            return good;
        }));
    for (auto& client : clients) EXPECT_EQ(client.get(), 3 * rounds);
}

TEST(HttpServer, ClosesConnectionsBeyondItsLimit) {
    ServerOptions options;
    options.max_connections = 2;
    RunningServer server(options);
    RawClient first(server.port), second(server.port);
    for (RawClient* client : {&first, &second}) {
        client->send(request("GET", "/livez"));
        EXPECT_EQ(client->receive().status, 200);
    }
    RawClient third(server.port);
    EXPECT_TRUE(third.is_closed());
    first.send(request("GET", "/livez"));
    EXPECT_EQ(first.receive().status, 200);
}

TEST(HttpServer, UploadsOverTheWire) {
    RunningServer server;
    const RawResponse created = server.exchange(request_with_body("/v1/assets?name=field", obj_field(20)));
    ASSERT_EQ(created.status, 202) << created.body;
    server.harness.bakes.wait_until_idle();
    const json asset = json::parse(server.exchange(request("GET", created.headers.at("location"))).body);
    EXPECT_EQ(asset["status"], "ready") << asset;
    EXPECT_EQ(server.exchange(request("GET", asset["levels"][0]["url"])).body.substr(0, 4), "glTF");
}

TEST(HttpServer, StopsIdleConnectionsAtOnce) {
    RunningServer server;
    RawClient idle(server.port), used(server.port);
    used.send(request("GET", "/livez"));
    EXPECT_EQ(used.receive().status, 200);
    server.stop();
    EXPECT_TRUE(server.wait());
    EXPECT_TRUE(idle.is_closed());
    EXPECT_TRUE(used.is_closed());
    EXPECT_THROW(RawClient(server.port), std::runtime_error);
}

TEST(HttpServer, FinishesRunningResponsesWhenItStops) {
    RunningServer server;
    std::string bytes;
    const std::string url = put_content(server.harness, 30'000'000, bytes);
    RawClient reader(server.port), sender(server.port);
    reader.send(request("GET", url));
    sender.send(request("POST", "/v1/plans", "Content-Length: 2\r\nExpect: 100-continue\r\n"));
    EXPECT_EQ(sender.receive().status, 100);
    server.stop();
    EXPECT_EQ(server.harness.get("/livez").status, 200);
    sender.send("{}");
    const RawResponse answer = sender.receive();
    EXPECT_EQ(answer.status, 400);
    EXPECT_EQ(answer.headers.at("connection"), "close");
    EXPECT_FALSE(server.has_ended());
    const RawResponse response = reader.receive();
    EXPECT_EQ(response.status, 200);
    EXPECT_TRUE(response.body == bytes);
    EXPECT_TRUE(server.wait());
    EXPECT_EQ(server.harness.get("/readyz").status, 503);
}

TEST(HttpServer, ClosesWhatDoesNotFinishWithinTheGrace) {
    ServerOptions options;
    options.shutdown_grace_s = 1;
    RunningServer server(options);
    RawClient stuck(server.port);
    stuck.send(request("POST", "/v1/plans", "Content-Length: 2\r\nExpect: 100-continue\r\n"));
    EXPECT_EQ(stuck.receive().status, 100);
    server.stop();
    EXPECT_TRUE(server.wait());
    EXPECT_EQ(stuck.receive().status, 0);
}

TEST(HttpServer, StopsOnASignal) {
    RunningServer server;
    EXPECT_EQ(server.exchange(request("GET", "/livez")).status, 200);
    ::raise(SIGTERM);
    EXPECT_TRUE(server.wait());
}

TEST(HttpServer, SaysWhyItCannotListen) {
    RunningServer server;
    ServerOptions options;
    const auto refusal = [&](const std::string& listen) {
        options.listen = listen;
        const auto status = serve(server.harness.service, options, {});
        return status ? "listened" : status.error().message;
    };
    EXPECT_THAT(refusal("127.0.0.1:" + std::to_string(server.port)), HasSubstr("in use"));
    EXPECT_THAT(refusal("8080"), HasSubstr("HOST:PORT"));
    EXPECT_THAT(refusal("127.0.0.1:99999"), HasSubstr("65535"));
    EXPECT_THAT(refusal("127.0.0.1:http"), HasSubstr("65535"));
    EXPECT_THAT(refusal("127.0.0.1:"), HasSubstr("65535"));
    EXPECT_THAT(refusal("300.1.1.1:1"), StartsWith("cannot listen on"));
}

}  // namespace
}  // namespace lodestream::http
