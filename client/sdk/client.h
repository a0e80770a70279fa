// What a program needs of the service: list, plan, fetch, decode. Blocking, over one kept-alive HTTP/1.1 connection.
// Nothing that arrives is trusted: every size, status, field and byte is checked, and a failure is one Error with the
// server's own `detail` where it sent one. A Client is used by one thread at a time, but for cancel().
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/codec/level_codec.h"
#include "common/codec/points_codec.h"
#include "proto/messages.h"
#include "proto/nodes.h"
#include "proto/tileset.h"

namespace lodestream::sdk {

inline constexpr double connect_timeout_s = 10.0;
inline constexpr double request_timeout_s = 120.0;  // from the first byte sent to the last one received
inline constexpr std::uint64_t max_json_bytes = 16ull << 20;
inline constexpr std::uint64_t max_tileset_bytes = 512ull << 20;
inline constexpr std::uint64_t max_content_bytes = 1ull << 30;
inline constexpr std::uint32_t max_header_bytes = 16u << 10;
inline constexpr std::uint32_t wait_interval_ms = 50;  // between two looks at an asset that is baking

struct ServerUrl {
    std::string host;  // without the brackets of an IPv6 address
    std::uint16_t port = 80;
};

// "http://HOST[:PORT][/]". Errors: unsupported (https), invalid_input (anything else).
Result<ServerUrl> parse_server_url(std::string_view url);

// A network to try instead of the one that is there.
struct Link {
    double downlink_mbps = 0.0;  // 10^6 bits a second, of what arrives; 0: no limit. What is sent is not slowed
    double rtt_ms = 0.0;         // >= 0, once a request, and once more for each connection made
};

struct Timing {
    double plan_ms = 0.0;
    double fetch_ms = 0.0;
    double decode_ms = 0.0;
};

struct Loaded {
    proto::PlanResponse plan;
    codec::Decoded content;
    std::optional<codec::Points> points;  // in place of the content, where the plan sent points
    std::uint64_t bytes = 0;              // of the content as fetched
    Timing timing;
};

class Client {
  public:
    // Parses the URL only; the connection is made by the first request and made anew where the server closed it.
    // With `link`, what arrives is read no faster than that, and no sooner.
    static Result<Client> open(std::string_view url, std::optional<Link> link = {});
    Client(Client&&) noexcept;
    Client& operator=(Client&&) noexcept;
    ~Client();

    Result<std::vector<proto::Asset>> assets();
    Result<proto::Asset> asset(const std::string& id);
    Result<proto::Asset> find_asset(const std::string& id_or_name);  // details as asset(); errors: not_found

    // Refuses a response that contradicts itself: a content URL that is not a path of this server, gouraud + flat that
    // is not the level's triangles, more triangles than the budget.
    Result<proto::PlanResponse> plan(const proto::PlanRequest& request);

    // The bytes behind a plan's content URL, exactly `expected_bytes` of them. Redirects are refused.
    Result<std::vector<std::byte>> fetch(const std::string& url, std::uint64_t expected_bytes);

    // The asset's levels as a tree, all of it; its tiles are fetched by their uri and bytes.
    Result<proto::Tileset> tileset(const std::string& asset_id);

    // The first of its documents alone, and one of those that it names, read below a tile of this matrix.
    Result<proto::Tileset> root_document(const std::string& asset_id);
    Result<proto::Tileset> document(const std::string& url, const Mat4d& place);
    // Adds all that are named and not there yet.
    Status add_documents(proto::Tileset& tileset);

    // The first document as soon as it is of a later revision than `after`; none where the server had none to tell for
    // a while.
    Result<std::optional<proto::Tileset>> newer_tileset(const std::string& asset_id, std::uint64_t after);

    // The nodes of a scene from `first` on, as many as the server tells at once.
    Result<proto::SceneNodes> nodes(const std::string& asset_id, std::uint32_t first = 0);
    // Moves, hides and shows nodes: all of the changes or none. `token` empty: none.
    Result<proto::NodesChanged> change_nodes(const std::string& asset_id, const std::vector<proto::NodeChange>& changes,
                                             const std::string& token = {});

    // plan → fetch → decode; the decoded level has the plan's triangles or points, or it is an error.
    Result<Loaded> load(const proto::PlanRequest& request);

    // Sends a model; the answered asset is still `baking`. Never sent twice. `token` empty: none.
    Result<proto::Asset> upload(const std::string& name, std::span<const std::byte> model,
                                const std::string& token = {});

    // Waits until the asset of this id or name is `ready`. Errors: not_found, invalid_input (its bake failed: why),
    // unavailable (still baking after `timeout_s`).
    Result<proto::Asset> wait_ready(const std::string& id_or_name, double timeout_s);

    // From any thread: the request under way and all later ones fail (unavailable) without waiting for the server.
    void cancel();

  private:
    struct Impl;
    explicit Client(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace lodestream::sdk
