#include "client/sdk/client.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <thread>
#include <utility>

#include "client/sdk/http_connection.h"

namespace lodestream::sdk {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t max_url_length = 2048;
constexpr std::size_t max_detail_length = 400;
constexpr int not_modified = 304;

double ms_since(Clock::time_point start) {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

// What a server says ends up on a terminal: one line, no control characters, not endless.
std::string one_line(std::string text) {
    for (char& c : text)
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
    if (text.size() > max_detail_length) text = text.substr(0, max_detail_length) + " …";
    return text;
}

ErrorCode code_of_status(int status) {
    switch (status) {
        case 400:
        case 422:
            return ErrorCode::invalid_input;
        case 401:
        case 403:
            return ErrorCode::unauthorized;
        case 404:
        case 410:
            return ErrorCode::not_found;
        case 409:
            return ErrorCode::conflict;
        case 413:
            return ErrorCode::limit_exceeded;
        case 415:
            return ErrorCode::unsupported;
        case 429:
        case 503:
            return ErrorCode::unavailable;
        default:
            return ErrorCode::io;
    }
}

Error refusal(const HttpRequest& request, const HttpResponse& response) {
    const std::string status = "HTTP " + std::to_string(response.status);
    if (response.content_type.starts_with("application/problem+json"))
        if (const auto problem = proto::parse_problem(response.body)) {
            const std::string& text = problem->detail.empty() ? problem->title : problem->detail;
            return fail(code_of_status(response.status), one_line(text) + " (" + status + ")");
        }
    const std::string where = request.method + " " + request.target + ": ";
    if (response.status >= 300 && response.status < 400)
        return fail(ErrorCode::io, where + "the server redirects, which is not followed (" + status + ")");
    return fail(code_of_status(response.status), where + "the server answered " + status);
}

bool is_unreserved(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '.' ||
           c == '_' || c == '~';
}

std::string percent_encode(std::string_view text) {
    constexpr std::string_view digits = "0123456789ABCDEF";
    std::string out;
    for (const char c : text) {
        if (is_unreserved(c)) {
            out += c;
            continue;
        }
        const auto byte = static_cast<unsigned char>(c);
        out += {'%', digits[byte >> 4], digits[byte & 15]};
    }
    return out;
}

// A path of the same server: no other host, no blanks or line ends that would break the request line.
bool is_server_path(const std::string& url) {
    const auto printable = [](char c) { return c > 0x20 && c < 0x7f; };
    return url.size() > 1 && url.size() <= max_url_length && url[0] == '/' && url[1] != '/' &&
           std::all_of(url.begin(), url.end(), printable);
}

Status check_plan(const proto::PlanResponse& plan) {
    const auto wrong = [](const std::string& what) {
        return fail(ErrorCode::io, "the server's plan is wrong: " + what);
    };
    if (!is_server_path(plan.content.url)) return wrong("content.url is not a path of the server");
    if (plan.content.bytes > max_content_bytes) return wrong("content.bytes is larger than the limit");
    if (plan.shading.gouraud > plan.level.triangles || plan.shading.flat != plan.level.triangles - plan.shading.gouraud)
        return wrong("gouraud + flat is not level.triangles");
    if (plan.level.triangles > plan.budget.triangles) return wrong("level.triangles exceeds the budget");
    if (plan.level.points > 0 && plan.level.triangles > 0) return wrong("level has points and triangles");
    if (plan.level.points > plan.budget.points.value_or(0)) return wrong("level.points exceeds the budget");
    return Nothing{};
}

std::uint64_t count_triangles(const codec::Decoded& content) {
    std::uint64_t count = 0;
    for (const codec::Primitive& primitive : content.primitives) count += primitive.mesh.triangles.size();
    return count;
}

Status decode_triangles(std::span<const std::byte> glb, Loaded& loaded) {
    auto content = codec::decode_level(glb);
    if (!content) return content.error();
    loaded.content = *std::move(content);
    const std::uint64_t triangles = count_triangles(loaded.content);
    if (triangles == loaded.plan.level.triangles) return Nothing{};
    return fail(ErrorCode::io, "holds " + std::to_string(triangles) + " triangles, the plan said " +
                                   std::to_string(loaded.plan.level.triangles));
}

Status decode_points(std::span<const std::byte> glb, Loaded& loaded) {
    auto decoded = codec::decode_points(glb);
    if (!decoded) return decoded.error();
    loaded.points = std::move(decoded->content);
    const std::uint64_t points = loaded.points->cloud.positions.size();
    if (points == loaded.plan.level.points) return Nothing{};
    return fail(ErrorCode::io, "holds " + std::to_string(points) + " points, the plan said " +
                                   std::to_string(loaded.plan.level.points));
}

}  // namespace

Result<ServerUrl> parse_server_url(std::string_view url) {
    constexpr std::string_view scheme = "http://";
    const auto wrong = [&](const std::string& what) {
        return invalid_input("server URL \"" + one_line(std::string(url)) + "\": " + what);
    };
    if (url.size() > max_url_length) return wrong("too long");
    if (url.starts_with("https://")) {
        Error error = wrong("https is not supported; put a TLS proxy in between and use http");
        error.code = ErrorCode::unsupported;
        return error;
    }
    if (!url.starts_with(scheme)) return wrong("expected http://HOST:PORT");
    std::string_view rest = url.substr(scheme.size());
    if (rest.ends_with('/')) rest.remove_suffix(1);
    ServerUrl out;
    if (rest.starts_with('[')) {
        const std::size_t end = rest.find(']');
        if (end == std::string_view::npos) return wrong("the IPv6 address has no closing bracket");
        out.host = rest.substr(1, end - 1);
        rest.remove_prefix(end + 1);
    } else {
        out.host = rest.substr(0, rest.find(':'));
        rest.remove_prefix(out.host.size());
    }
    const auto allowed = [](char c) { return is_unreserved(c) || c == ':'; };
    if (out.host.empty() || !std::all_of(out.host.begin(), out.host.end(), allowed)) return wrong("the host is wrong");
    if (rest.empty()) return out;
    const char* end = rest.data() + rest.size();
    const auto port = std::from_chars(rest.data() + 1, end, out.port);
    if (rest[0] != ':' || port.ec != std::errc{} || port.ptr != end || out.port == 0)
        return wrong("the port must be 1 to 65535");
    return out;
}

struct Client::Impl {
    Impl(ServerUrl server, std::optional<Link> link) : connection(std::move(server), link) {}
    HttpConnection connection;

    // The body of a 2xx response; none of one that says that nothing has changed.
    Result<std::optional<std::string>> send_unless_unchanged(const HttpRequest& request, std::uint64_t max_body_bytes) {
        auto response = connection.exchange(request, max_body_bytes);
        if (!response) return response.error();
        if (response->status == not_modified) return std::optional<std::string>();
        if (response->status < 200 || response->status >= 300) return refusal(request, *response);
        return std::optional(std::move(response->body));
    }

    Result<std::string> send(const HttpRequest& request, std::uint64_t max_body_bytes) {
        auto body = send_unless_unchanged(request, max_body_bytes);
        if (!body) return body.error();
        if (!*body) return refusal(request, {not_modified, {}, {}});
        return **std::move(body);
    }

    template <class T>
    Result<T> send_for(const HttpRequest& request, Result<T> (*parse)(std::string_view),
                       std::uint64_t max_bytes = max_json_bytes) {
        const auto body = send(request, max_bytes);
        if (!body) return body.error();
        return parsed(request, *body, parse);
    }

    template <class T>
    static Result<T> parsed(const HttpRequest& request, const std::string& body, Result<T> (*parse)(std::string_view)) {
        return read(request, parse(body));
    }

    // What was read of the answer.
    template <class T>
    static Result<T> read(const HttpRequest& request, Result<T> parsed) {
        if (parsed) return parsed;
        return fail(ErrorCode::io, request.method + " " + request.target +
                                       ": the server's answer is wrong: " + one_line(parsed.error().message));
    }
};

Client::Client(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Client::Client(Client&&) noexcept = default;
Client& Client::operator=(Client&&) noexcept = default;
Client::~Client() = default;

Result<Client> Client::open(std::string_view url, std::optional<Link> link) {
    auto server = parse_server_url(url);
    if (!server) return server.error();
    if (link && !(link->downlink_mbps >= 0.0 && std::isfinite(link->downlink_mbps) && link->rtt_ms >= 0.0 &&
                  std::isfinite(link->rtt_ms)))
        return invalid_input("a link needs a rate of at least 0 Mbit/s and a round trip of at least 0 ms");
    return Client(std::make_unique<Impl>(*std::move(server), link));
}

Result<std::vector<proto::Asset>> Client::assets() {
    HttpRequest request;
    request.target = "/v1/assets";
    return impl_->send_for(request, proto::parse_assets);
}

Result<proto::Asset> Client::asset(const std::string& id) {
    HttpRequest request;
    request.target = "/v1/assets/" + percent_encode(id);
    return impl_->send_for(request, proto::parse_asset);
}

Result<proto::Asset> Client::find_asset(const std::string& id_or_name) {
    const auto list = assets();
    if (!list) return list.error();
    const auto found = std::find_if(list->begin(), list->end(),
                                    [&](const proto::Asset& a) { return a.id == id_or_name || a.name == id_or_name; });
    if (found == list->end()) return fail(ErrorCode::not_found, "no asset \"" + id_or_name + "\" on the server");
    return asset(found->id);
}

Result<proto::Tileset> Client::tileset(const std::string& asset_id) {
    auto tileset = root_document(asset_id);
    if (!tileset) return tileset;
    if (Status added = add_documents(*tileset); !added) return added.error();
    return tileset;
}

Status Client::add_documents(proto::Tileset& tileset) {
    for (std::uint32_t node = 0; node < tileset.nodes.size(); ++node) {
        if (!proto::begins_document(tileset, node)) continue;
        const auto more = document(tileset.documents[node], tileset.matrix(node));
        if (!more) return more.error();
        if (Status added = proto::add_document(tileset, node, *more); !added) return added;
    }
    return Nothing{};
}

Result<proto::Tileset> Client::document(const std::string& url, const Mat4d& place) {
    if (!is_server_path(url)) return invalid_input("a document's address is not a path of the server");
    HttpRequest request;
    request.target = url;
    const auto body = impl_->send(request, max_tileset_bytes);
    if (!body) return body.error();
    return Impl::read(request, proto::parse_document(*body, place));
}

Result<proto::Tileset> Client::root_document(const std::string& asset_id) {
    HttpRequest request;
    request.target = "/v1/assets/" + percent_encode(asset_id) + "/tileset.json";
    return impl_->send_for(request, proto::parse_tileset, max_tileset_bytes);
}

Result<std::optional<proto::Tileset>> Client::newer_tileset(const std::string& asset_id, std::uint64_t after) {
    HttpRequest request;
    request.target = "/v1/assets/" + percent_encode(asset_id) + "/tileset.json?after=" + std::to_string(after);
    const auto body = impl_->send_unless_unchanged(request, max_tileset_bytes);
    if (!body) return body.error();
    if (!*body) return std::optional<proto::Tileset>();
    auto tileset = Impl::parsed(request, **body, proto::parse_tileset);
    if (!tileset) return tileset.error();
    return std::optional(*std::move(tileset));
}

Result<proto::SceneNodes> Client::nodes(const std::string& asset_id, std::uint32_t first) {
    HttpRequest request;
    request.target = "/v1/assets/" + percent_encode(asset_id) + "/nodes?first=" + std::to_string(first);
    return impl_->send_for(request, proto::parse_scene_nodes);
}

Result<proto::NodesChanged> Client::change_nodes(const std::string& asset_id,
                                                 const std::vector<proto::NodeChange>& changes,
                                                 const std::string& token) {
    const std::string json = proto::to_json(changes);
    HttpRequest request;
    request.method = "PATCH";
    request.target = "/v1/assets/" + percent_encode(asset_id) + "/nodes";
    request.content_type = "application/json";
    request.body = std::as_bytes(std::span(json));
    request.token = token;  // places are absolute, so that a request may be sent again
    return impl_->send_for(request, proto::parse_nodes_changed);
}

Result<proto::PlanResponse> Client::plan(const proto::PlanRequest& plan_request) {
    const std::string json = proto::to_json(plan_request);
    HttpRequest request;
    request.method = "POST";
    request.target = "/v1/plans";
    request.content_type = "application/json";
    request.body = std::as_bytes(std::span(json));
    auto plan = impl_->send_for(request, proto::parse_plan_response);
    if (!plan) return plan;
    if (auto sound = check_plan(*plan); !sound) return sound.error();
    return plan;
}

Result<std::vector<std::byte>> Client::fetch(const std::string& url, std::uint64_t expected_bytes) {
    if (!is_server_path(url)) return invalid_input("content URL is not a path of the server");
    if (expected_bytes > max_content_bytes) return fail(ErrorCode::limit_exceeded, url + ": larger than the limit");
    HttpRequest request;
    request.target = url;
    const auto body = impl_->send(request, expected_bytes);
    if (!body) return body.error();
    if (body->size() != expected_bytes)
        return fail(ErrorCode::io, url + ": " + std::to_string(body->size()) + " bytes arrived instead of " +
                                       std::to_string(expected_bytes));
    const auto bytes = std::as_bytes(std::span(*body));
    return std::vector<std::byte>(bytes.begin(), bytes.end());
}

Result<Loaded> Client::load(const proto::PlanRequest& request) {
    Loaded loaded;
    const auto plan_start = Clock::now();
    auto planned = plan(request);
    if (!planned) return planned.error();
    loaded.timing.plan_ms = ms_since(plan_start);
    loaded.plan = *std::move(planned);

    const auto fetch_start = Clock::now();
    const auto glb = fetch(loaded.plan.content.url, loaded.plan.content.bytes);
    if (!glb) return glb.error();
    loaded.timing.fetch_ms = ms_since(fetch_start);
    loaded.bytes = glb->size();

    const auto decode_start = Clock::now();
    const bool is_cloud = loaded.plan.level.points > 0;
    if (auto decoded = is_cloud ? decode_points(*glb, loaded) : decode_triangles(*glb, loaded); !decoded)
        return fail(decoded.error().code, loaded.plan.content.url + ": " + one_line(decoded.error().message));
    loaded.timing.decode_ms = ms_since(decode_start);
    return loaded;
}

Result<proto::Asset> Client::upload(const std::string& name, std::span<const std::byte> model,
                                    const std::string& token) {
    HttpRequest request;
    request.method = "POST";
    request.target = "/v1/assets?name=" + percent_encode(name);
    request.content_type = "application/octet-stream";
    request.body = model;
    request.token = token;
    request.repeatable = false;
    return impl_->send_for(request, proto::parse_asset);
}

void Client::cancel() {
    impl_->connection.cancel();
}

Result<proto::Asset> Client::wait_ready(const std::string& id_or_name, double timeout_s) {
    const auto start = Clock::now();
    for (;;) {
        auto list = assets();
        if (!list) return list.error();
        const auto found = std::find_if(list->begin(), list->end(), [&](const proto::Asset& a) {
            return a.id == id_or_name || a.name == id_or_name;
        });
        if (found == list->end()) return fail(ErrorCode::not_found, "no asset \"" + id_or_name + "\" on the server");
        if (found->status == proto::AssetStatus::ready) return asset(found->id);
        if (found->status == proto::AssetStatus::failed)
            return invalid_input("asset \"" + id_or_name + "\" failed to bake: " + one_line(found->error));
        if (ms_since(start) >= timeout_s * 1e3)
            return fail(ErrorCode::unavailable, "asset \"" + id_or_name + "\" is still baking");
        std::this_thread::sleep_for(std::chrono::milliseconds(wait_interval_ms));
    }
}

}  // namespace lodestream::sdk
