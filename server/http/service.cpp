#include "server/http/service.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cctype>
#include <charconv>
#include <chrono>
#include <memory>
#include <mutex>
#include <set>

#include "proto/openapi.h"
#include "proto/tileset.h"
#include "server/bake/bake.h"
#include "server/bake/tile_tree.h"
#include "server/http/byte_range.h"
#include "server/http/metrics.h"
#include "server/http/packing.h"
#include "server/http/page.h"

namespace lodestream::http {

namespace {

constexpr const char* retry_after_s = "1";
constexpr const char* after_name = "after";  // of the query for a newer tileset
constexpr const char* tile_name = "tile";    // of the query for one of its documents
constexpr const char* json_type = "application/json";
constexpr const char* text_type = "text/plain; charset=utf-8";
constexpr const char* metrics_type = "text/plain; version=0.0.4; charset=utf-8";
constexpr const char* html_type = "text/html; charset=utf-8";
constexpr const char* glb_type = "model/gltf-binary";
constexpr const char* immutable = "public, max-age=31536000, immutable";
constexpr const char* page_policy =
    "default-src 'none'; connect-src 'self'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'; "
    "base-uri 'none'";

Response respond(const char* type, std::string body, const char* cache_control = "no-cache") {
    Response response;
    response.headers["content-type"] = type;
    response.headers["cache-control"] = cache_control;
    response.body = std::move(body);
    return response;
}

Response respond(const proto::Problem& problem) {
    Response response = respond("application/problem+json", proto::to_json(problem), "no-store");
    response.status = problem.status;
    if (problem.status == 401) response.headers["www-authenticate"] = "Bearer";
    if (problem.status == 503) response.headers["retry-after"] = retry_after_s;
    return response;
}

Response respond(const Error& error) {
    return respond(proto::problem_of(error));
}

Response respond(int status, const char* kind, const char* title, std::string detail) {
    return respond(proto::Problem{status, title, std::move(detail), std::string("urn:lodestream:problem:") + kind});
}

Response bad_request(std::string detail) {
    return respond(400, "bad-request", "Bad request", std::move(detail));
}

const std::string* header(const Request& request, const char* name) {
    const auto it = request.headers.find(name);
    return it == request.headers.end() ? nullptr : &it->second;
}

std::string lower(std::string_view text) {
    std::string result(text);
    for (char& c : result) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return result;
}

// "Text/HTML; charset=x" is "text/html".
std::string media_type(const Request& request) {
    const std::string* field = header(request, "content-type");
    if (!field) return {};
    const std::string type = field->substr(0, field->find(';'));
    const auto last = type.find_last_not_of(" \t");
    return last == std::string::npos ? std::string{} : lower(type.substr(0, last + 1));
}

bool equal_in_constant_time(std::string_view given, std::string_view secret) {
    unsigned difference = given.size() == secret.size() ? 0 : 1;
    for (std::size_t i = 0; i < given.size(); ++i)
        difference |= static_cast<unsigned char>(given[i]) ^ static_cast<unsigned char>(secret[i % secret.size()]);
    return difference == 0;
}

bool has_token(const Request& request, const std::string& token) {
    constexpr std::string_view scheme = "bearer ";
    const std::string* field = header(request, "authorization");
    if (!field || field->size() < scheme.size() || lower(field->substr(0, scheme.size())) != scheme) return false;
    std::string_view given = std::string_view(*field).substr(scheme.size());
    while (given.starts_with(' ')) given.remove_prefix(1);
    return equal_in_constant_time(given, token);
}

// A browser names the page's origin; a page of this server itself has the request's Host.
bool is_cross_origin(const Request& request) {
    const std::string* origin = header(request, "origin");
    const std::string* host = header(request, "host");
    if (!origin) return false;
    const auto scheme_end = origin->find("://");
    return !host || scheme_end == std::string::npos || lower(origin->substr(scheme_end + 3)) != lower(*host);
}

}  // namespace

struct Service::Impl {
    enum class Kind { read, plan, change };
    struct Route {
        const char* method;     // GET answers HEAD too
        std::string_view path;  // as in openapi.yaml; what stands for the braces is handed to the answer
        Kind kind;
        bool heavy;
        Response (Impl::*answer)(Request& request, const std::string& captured);
    };
    static const std::array<Route, 14> routes;

    // What a method and path lead to.
    struct Match {
        const Route* route = nullptr;    // null: no such path, or not by this method
        std::string_view path = "none";  // of the route, or of one for another method
        std::string captured;
    };
    static Match match(const Request& request);
    static std::string methods_of(std::string_view route_path, bool for_other_origins);

    store::Store& store;
    planner::Planner& planner;
    BakeQueue& bakes;
    live::LiveScenes& scenes;
    ServiceOptions options;
    std::atomic<bool> stopping{false};
    Metrics metrics;

    Impl(store::Store& s, planner::Planner& p, BakeQueue& b, live::LiveScenes& l, ServiceOptions o)
        : store(s), planner(p), bakes(b), scenes(l), options(std::move(o)) {}

    Response answer(Request& request, const Match& found);
    std::optional<Response> refuse_head(const Request& head, const Match& found) const;
    std::optional<Response> refuse_change(const Request& head) const;
    void finish(Response& response, const Request& request, const Match& found, double seconds);

    Response livez(Request& request, const std::string&);
    Response readyz(Request& request, const std::string&);
    Response metrics_page(Request& request, const std::string&);
    Response index(Request& request, const std::string&);
    Response openapi(Request& request, const std::string&);
    Response list_assets(Request& request, const std::string&);
    Response create_asset(Request& request, const std::string&);
    Response get_asset(Request& request, const std::string& id);
    Response delete_asset(Request& request, const std::string& id);
    Response tileset(Request& request, const std::string& id);
    Response list_nodes(Request& request, const std::string& id);
    Response change_nodes(Request& request, const std::string& id);
    Response create_plan(Request& request, const std::string&);
    Response content(Request& request, const std::string& hash);

    // A tileset of several documents, of which one after the other is asked for.
    struct Told {
        std::string asset_id, version;
        std::shared_ptr<const proto::Tileset> tileset;
    };
    std::mutex told_mutex;
    Told told;  // the last one

    Result<std::shared_ptr<const proto::Tileset>> tileset_now(const proto::Asset& asset);
    Result<proto::Tileset> make_tileset(const proto::Asset& asset, const live::LiveScene* scene);
    std::size_t moved_objects_of(const std::string& id_or_name);

    void add_progress(proto::Asset& asset) const {
        if (asset.status == proto::AssetStatus::baking) asset.progress = bakes.progress(asset.id);
    }
};

const std::array<Service::Impl::Route, 14> Service::Impl::routes{{
    {"GET", "/livez", Kind::read, false, &Impl::livez},
    {"GET", "/readyz", Kind::read, true, &Impl::readyz},
    {"GET", "/metrics", Kind::read, false, &Impl::metrics_page},
    {"GET", "/", Kind::read, false, &Impl::index},
    {"GET", "/openapi.json", Kind::read, false, &Impl::openapi},
    {"GET", "/v1/assets", Kind::read, false, &Impl::list_assets},
    {"POST", "/v1/assets", Kind::change, true, &Impl::create_asset},
    {"GET", "/v1/assets/{id}", Kind::read, false, &Impl::get_asset},
    {"DELETE", "/v1/assets/{id}", Kind::change, true, &Impl::delete_asset},
    {"GET", "/v1/assets/{id}/tileset.json", Kind::read, true, &Impl::tileset},
    {"GET", "/v1/assets/{id}/nodes", Kind::read, true, &Impl::list_nodes},
    {"PATCH", "/v1/assets/{id}/nodes", Kind::change, true, &Impl::change_nodes},
    {"POST", "/v1/plans", Kind::plan, true, &Impl::create_plan},
    {"GET", "/v1/content/{hash}.glb", Kind::read, false, &Impl::content},
}};

namespace {

// What stands for the braces of `pattern`, one segment; an empty text where there are none.
std::optional<std::string> capture(std::string_view pattern, std::string_view path) {
    const auto open = pattern.find('{');
    if (open == std::string_view::npos) return path == pattern ? std::optional<std::string>("") : std::nullopt;
    const std::string_view before = pattern.substr(0, open);
    const std::string_view after = pattern.substr(pattern.find('}') + 1);
    if (path.size() <= before.size() + after.size() || !path.starts_with(before) || !path.ends_with(after))
        return std::nullopt;
    const std::string_view middle = path.substr(before.size(), path.size() - before.size() - after.size());
    if (middle.find('/') != std::string_view::npos) return std::nullopt;
    return std::string(middle);
}

// Keeps the figures' labels a bounded set, whatever clients send.
std::string_view method_label(const std::string& method) {
    for (const std::string_view known : {"GET", "HEAD", "POST", "PATCH", "DELETE", "OPTIONS"})
        if (method == known) return known;
    return "other";
}

std::string_view text_of(const std::vector<std::byte>& body) {
    return {reinterpret_cast<const char*>(body.data()), body.size()};
}

bool read_number(const std::string& text, std::uint64_t& out) {
    const auto [end, wrong] = std::from_chars(text.data(), text.data() + text.size(), out);
    return wrong == std::errc() && end == text.data() + text.size();
}

std::uint64_t body_bytes(const Response& response) {
    return response.file ? response.file_length : response.body.size();
}

bool is_json_type(const std::string& type) {
    // curl -d says application/x-www-form-urlencoded of whatever it sends.
    return type.empty() || type == "application/json" || type.ends_with("+json") || type == "text/plain" ||
           type == "application/x-www-form-urlencoded";
}

}  // namespace

auto Service::Impl::match(const Request& request) -> Match {
    Match found;
    const std::string_view method = request.method == "HEAD" ? "GET" : std::string_view(request.method);
    for (const Route& route : routes) {
        auto captured = capture(route.path, request.path);
        if (!captured) continue;
        found.path = route.path;
        if (method != route.method) continue;
        found.route = &route;
        found.captured = *std::move(captured);
        break;
    }
    return found;
}

std::string Service::Impl::methods_of(std::string_view route_path, bool for_other_origins) {
    std::set<std::string_view> methods{"OPTIONS"};
    for (const Route& route : routes) {
        if (route.path != route_path || (for_other_origins && route.kind == Kind::change)) continue;
        methods.insert(route.method);
        if (methods.contains("GET")) methods.insert("HEAD");
    }
    std::string text;
    for (const std::string_view method : methods) text.append(text.empty() ? "" : ", ").append(method);
    return text;
}

// Who may change assets: whoever has the token; without one, anybody but a page of another origin.
std::optional<Response> Service::Impl::refuse_change(const Request& head) const {
    if (!options.token.empty()) {
        if (has_token(head, options.token)) return std::nullopt;
        return respond(fail(ErrorCode::unauthorized, "this needs the server's token: Authorization: Bearer …"));
    }
    if (!is_cross_origin(head)) return std::nullopt;
    return respond(403, "forbidden", "Forbidden",
                   "a page of another origin may not change assets; set a token to allow it");
}

std::optional<Response> Service::Impl::refuse_head(const Request& head, const Match& found) const {
    const bool known = found.path != Match{}.path;
    if (head.method == "OPTIONS" && (known || head.path == "*")) {
        Response response;
        response.status = 204;
        response.headers["allow"] = methods_of(found.path, false);
        response.headers["access-control-allow-methods"] = methods_of(found.path, true);
        response.headers["access-control-allow-headers"] = "Content-Type, If-None-Match, If-Range, Range";
        response.headers["access-control-max-age"] = "86400";
        return response;
    }
    if (!known) return respond(fail(ErrorCode::not_found, "there is nothing at " + head.path));
    if (!found.route) {
        const std::string methods = methods_of(found.path, false);
        Response response = respond(405, "method-not-allowed", "Method not allowed",
                                    head.path + " answers " + methods + ", not " + head.method);
        response.headers["allow"] = methods;
        return response;
    }
    if (found.route->kind == Kind::change)
        if (auto refused = refuse_change(head)) return refused;
    const bool is_json = found.route->kind == Kind::plan || found.route->method == std::string_view("PATCH");
    if (found.route->method != std::string_view("POST") && !is_json) return std::nullopt;
    const std::string type = media_type(head);
    const std::string* encoding = header(head, "content-encoding");
    if (encoding && lower(*encoding) != "identity")
        return respond(fail(ErrorCode::unsupported,
                            "the content encoding \"" + *encoding + "\" is not handled; send the bytes as they are"));
    if (is_json && !is_json_type(type))
        return respond(fail(ErrorCode::unsupported, "the body must be application/json, not " + type));
    if (is_json) return std::nullopt;
    if (type.starts_with("multipart/"))
        return respond(fail(ErrorCode::unsupported, "send the model itself as the body, not a form"));
    if (!head.query.contains("name")) return bad_request("the query needs name=…, the asset's name");
    return std::nullopt;
}

Response Service::Impl::answer(Request& request, const Match& found) {
    try {
        if (auto refused = refuse_head(request, found)) return *std::move(refused);
        return (this->*found.route->answer)(request, found.captured);
    } catch (const std::bad_alloc&) {
        return respond(fail(ErrorCode::unavailable, "not enough memory"));
    } catch (const std::exception& e) {
        return respond(fail(ErrorCode::internal, e.what()));
    }
}

void Service::Impl::finish(Response& response, const Request& request, const Match& found, double seconds) {
    response.headers["x-content-type-options"] = "nosniff";
    pack_body(response, request);
    const bool open = request.method == "OPTIONS" || !found.route || found.route->kind != Kind::change;
    if (open) {
        response.headers["access-control-allow-origin"] = "*";
        response.headers["access-control-expose-headers"] = "Accept-Ranges, Content-Range, ETag, Retry-After";
    }
    metrics.count_request(method_label(request.method), found.path, response.status, seconds,
                          request.method == "HEAD" ? 0 : body_bytes(response));
}

Response Service::Impl::livez(Request&, const std::string&) {
    return respond(text_type, "ok\n", "no-store");
}

Response Service::Impl::readyz(Request&, const std::string&) {
    if (stopping) return respond(fail(ErrorCode::unavailable, "the server is stopping"));
    if (auto status = store.check(); !status)
        return respond(fail(ErrorCode::unavailable, "the store takes no writes: " + status.error().message));
    return respond(text_type, "ok\n", "no-store");
}

Response Service::Impl::metrics_page(Request&, const std::string&) {
    const auto assets = store.assets();
    if (!assets) return respond(assets.error());
    return respond(metrics_type, metrics.text(bakes.counts(), *assets), "no-store");
}

Response Service::Impl::index(Request&, const std::string&) {
    Response response = respond(html_type, std::string(index_html()));
    response.headers["content-security-policy"] = page_policy;
    return response;
}

Response Service::Impl::openapi(Request&, const std::string&) {
    return respond(json_type, std::string(proto::openapi_json()));
}

Response Service::Impl::list_assets(Request&, const std::string&) {
    auto assets = store.assets();
    if (!assets) return respond(assets.error());
    for (proto::Asset& asset : *assets) add_progress(asset);
    return respond(json_type, proto::to_json(*assets));
}

Response Service::Impl::create_asset(Request& request, const std::string&) {
    if (stopping) return respond(fail(ErrorCode::unavailable, "the server is stopping"));
    if (request.body.empty()) return respond(invalid_input("the body is empty; it must be the model"));
    const auto asset = bakes.submit(request.query.at("name"), std::move(request.body));
    if (!asset) return respond(asset.error());
    Response response = respond(json_type, proto::to_json(*asset));
    response.status = 202;
    response.headers["location"] = "/v1/assets/" + asset->id;
    return response;
}

Response Service::Impl::get_asset(Request&, const std::string& id) {
    auto asset = store.asset(id);
    if (!asset) return respond(asset.error());
    add_progress(*asset);
    return respond(json_type, proto::to_json(*asset));
}

Response Service::Impl::delete_asset(Request&, const std::string& id) {
    const auto asset = store.asset(id);
    if (!asset) return respond(asset.error());
    bakes.cancel(asset->id);
    // A cancelled bake may have removed it already.
    if (auto status = store.remove_asset(asset->id); !status && status.error().code != ErrorCode::not_found)
        return respond(status.error());
    planner.forget(asset->id);
    scenes.forget(asset->id);
    Response response;
    response.status = 204;
    return response;
}

// The tileset as it is now, in documents; of a scene whose nodes were changed, with a revision.
Result<proto::Tileset> Service::Impl::make_tileset(const proto::Asset& asset, const live::LiveScene* scene) {
    proto::Tileset tileset;
    if (scene) {
        tileset = scene->tileset();
    } else {
        auto tiles = bake::load_tiles(store, asset);
        if (!tiles) return tiles.error();
        for (std::string& hash : tiles->hashes) hash = bake::content_url(hash);
        tileset = {std::move(tiles->nodes), std::move(tiles->hashes), std::move(tiles->bytes), tiles->is_additive,
                   std::move(tiles->matrices)};
    }
    proto::split_into_documents(tileset, [&](std::uint64_t id, std::uint64_t version) {
        return "/v1/assets/" + asset.id + "/tileset.json?" + tile_name + "=" + std::to_string(id) +
               "&version=" + std::to_string(version);
    });
    return tileset;
}

Result<std::shared_ptr<const proto::Tileset>> Service::Impl::tileset_now(const proto::Asset& asset) {
    const auto scene = scenes.find_changed(asset);
    if (!scene) return scene.error();
    const auto tiles = store.content(asset.id, std::string(bake::tiles_key));
    const std::string version = (tiles ? tiles->file.hash : "") + (*scene ? std::to_string((*scene)->revision()) : "");
    {
        const std::lock_guard lock(told_mutex);
        if (told.asset_id == asset.id && told.version == version) return told.tileset;
    }
    auto made = make_tileset(asset, scene->get());
    if (!made) return made.error();
    auto tileset = std::make_shared<const proto::Tileset>(*std::move(made));
    if (tileset->documents.empty() || (*scene && tileset->revision != (*scene)->revision())) return tileset;
    const std::lock_guard lock(told_mutex);
    told = {asset.id, version, tileset};
    return tileset;
}

Response Service::Impl::tileset(Request& request, const std::string& id) {
    std::uint64_t after = 0, tile = 0;
    const bool is_poll = request.query.contains(after_name), is_part = request.query.contains(tile_name);
    if (is_poll && !read_number(request.query.at(after_name), after))
        return bad_request("after must be a revision, a whole number");
    if (is_part && !read_number(request.query.at(tile_name), tile)) return bad_request("tile must be a tile's id");
    if (is_poll && is_part) return bad_request("after is of the whole tileset, not of one of its tiles");
    const auto asset = store.asset(id);
    if (!asset) return respond(asset.error());
    const auto now = tileset_now(*asset);
    if (!now) return respond(now.error());
    const proto::Tileset& tileset = **now;
    if (is_part) {
        const auto found = std::find(tileset.ids.begin(), tileset.ids.end(), tile);
        if (found == tileset.ids.end())
            return respond(fail(ErrorCode::not_found, "the tileset has no tile " + std::to_string(tile)));
        const auto document = static_cast<std::uint32_t>(found - tileset.ids.begin());
        return respond(json_type, proto::to_json(tileset, document));
    }
    if (!is_poll || tileset.revision > after) return respond(json_type, proto::to_json(tileset));
    Response response;
    response.status = 304;
    response.headers["cache-control"] = "no-cache";
    return response;
}

Response Service::Impl::list_nodes(Request& request, const std::string& id) {
    std::uint64_t first = 0, count = live::max_listed_nodes;
    for (const auto& [name, number] : {std::pair{"first", &first}, {"count", &count}})
        if (request.query.contains(name) && !read_number(request.query.at(name), *number))
            return bad_request(std::string(name) + " must be a whole number");
    const auto asset = store.asset(id);
    if (!asset) return respond(asset.error());
    const auto scene = scenes.find(*asset);
    if (!scene) return respond(scene.error());
    return respond(json_type, proto::to_json((*scene)->nodes(first, count)));
}

Response Service::Impl::change_nodes(Request& request, const std::string& id) {
    if (stopping) return respond(fail(ErrorCode::unavailable, "the server is stopping"));
    const auto asset = store.asset(id);
    if (!asset) return respond(asset.error());
    const auto changes = proto::parse_node_changes(text_of(request.body));
    if (!changes && changes.error().code == ErrorCode::invalid_input) return bad_request(changes.error().message);
    if (!changes) return respond(changes.error());
    const auto changed = scenes.change(*asset, *changes);
    if (!changed) return respond(changed.error());
    return respond(json_type, proto::to_json(*changed), "no-store");
}

std::size_t Service::Impl::moved_objects_of(const std::string& id_or_name) {
    const auto asset = store.asset(id_or_name);
    if (!asset || !asset->hierarchy) return 0;
    const auto scene = scenes.find_changed(*asset);
    return scene && *scene ? (*scene)->moved_objects() : 0;
}

Response Service::Impl::create_plan(Request& request, const std::string&) {
    const auto wanted = proto::parse_plan_request(text_of(request.body));
    if (!wanted) return bad_request(wanted.error().message);
    auto plan = planner.plan(*wanted);
    if (!plan) return respond(plan.error());
    if (const std::size_t moved = moved_objects_of(wanted->asset); moved > 0)
        plan->warnings.push_back("the level shows the scene as it was baked; " + std::to_string(moved) +
                                 " of its objects have moved since, which its tileset shows");
    metrics.count_plan(plan->budget.limited_by);
    return respond(json_type, proto::to_json(*plan), "no-store");
}

Response Service::Impl::content(Request& request, const std::string& hash) {
    const auto file = store.file(hash, "glb");
    if (!file) return respond(file.error());
    const std::string etag = '"' + file->hash + '"', packed_etag = '"' + file->hash + "-gzip\"";
    const bool packs = takes_gzip(request) && file->bytes <= most_packed_file_bytes;
    Response response;
    response.headers["etag"] = packs ? packed_etag : etag;
    response.headers["cache-control"] = immutable;
    response.headers["accept-ranges"] = "bytes";
    response.headers["vary"] = "Accept-Encoding";
    if (const std::string* known = header(request, "if-none-match");
        known && (names_etag(*known, etag) || names_etag(*known, packed_etag))) {
        response.status = 304;
        return response;
    }
    RangeAnswer range{RangeAnswer::Kind::whole, 0, 0};
    const std::string* unchanged = header(request, "if-range");
    if (const std::string* field = header(request, "range");
        field && request.method == "GET" && (!unchanged || *unchanged == etag))
        range = answer_range(*field, file->bytes);
    if (range.kind == RangeAnswer::Kind::unsatisfiable) {
        response = respond(416, "range-not-satisfiable", "Range not satisfiable",
                           "the content has " + std::to_string(file->bytes) + " bytes");
        response.headers["content-range"] = "bytes */" + std::to_string(file->bytes);
        return response;
    }
    response.headers["content-type"] = glb_type;
    if (packs) {
        std::optional<std::string> packed = packed_glb(*file);
        if (!packed) return respond(fail(ErrorCode::not_found, "this content has just been removed"));
        response.headers["content-encoding"] = "gzip";
        response.body = *std::move(packed);
        return response;
    }
    response.file = *file;
    response.file_length = file->bytes;
    if (range.kind == RangeAnswer::Kind::part) {
        response.status = 206;
        response.file_offset = range.offset;
        response.file_length = range.length;
        response.headers["content-range"] = "bytes " + std::to_string(range.offset) + "-" +
                                            std::to_string(range.offset + range.length - 1) + "/" +
                                            std::to_string(file->bytes);
    }
    return response;
}

Service::Service(store::Store& store, planner::Planner& planner, BakeQueue& bakes, live::LiveScenes& scenes,
                 ServiceOptions options)
    : impl_(std::make_unique<Impl>(store, planner, bakes, scenes, std::move(options))) {}

Service::~Service() = default;

Response Service::handle(Request request) {
    const auto start = std::chrono::steady_clock::now();
    const Impl::Match found = Impl::match(request);
    Response response = impl_->answer(request, found);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    impl_->finish(response, request, found, took.count());
    return response;
}

std::optional<Response> Service::refuse_early(const Request& head) {
    const Impl::Match found = Impl::match(head);
    auto response = impl_->refuse_head(head, found);
    if (response) impl_->finish(*response, head, found, 0.0);
    return response;
}

Response Service::refuse(int status, const std::string& detail) {
    struct Kind {
        int status;
        const char* kind;
        const char* title;
    };
    static constexpr std::array<Kind, 7> kinds{{{400, "bad-request", "Bad request"},
                                                {404, "not-found", "Not found"},
                                                {408, "timeout", "Request timeout"},
                                                {411, "length-required", "Length required"},
                                                {413, "limit-exceeded", "Too large"},
                                                {431, "headers-too-large", "Header fields too large"},
                                                {505, "version", "HTTP version not supported"}}};
    const auto kind = std::find_if(kinds.begin(), kinds.end(), [&](const Kind& k) { return k.status == status; });
    Response response = kind != kinds.end() ? respond(status, kind->kind, kind->title, detail)
                                            : respond(fail(ErrorCode::unavailable, detail));
    impl_->finish(response, Request{"refused", "", {}, {}, {}}, {}, 0.0);
    return response;
}

bool Service::is_heavy(const Request& head) {
    const Impl::Match found = Impl::match(head);
    return found.route && found.route->heavy;
}

std::optional<Service::Poll> Service::poll_of(const Request& request) const {
    const auto after = request.query.find(after_name);
    Poll poll;
    if (after == request.query.end() || request.query.contains(tile_name) || !read_number(after->second, poll.after))
        return std::nullopt;
    const Impl::Match found = Impl::match(request);
    if (!found.route || found.route->answer != &Impl::tileset) return std::nullopt;
    const auto asset = impl_->store.asset(found.captured);
    if (!asset) return std::nullopt;
    poll.asset_id = asset->id;
    return poll;
}

bool Service::is_waiting(const Poll& poll) const {
    return !impl_->stopping && impl_->scenes.revision(poll.asset_id) <= poll.after;
}

bool Service::is_upload(const Request& head) {
    const Impl::Match found = Impl::match(head);
    return found.route && found.route->answer == &Impl::create_asset;
}

void Service::stop_accepting() {
    impl_->stopping = true;
}

}  // namespace lodestream::http
