// Bodies in the coding that saves: gzip, for a client that takes it.
#pragma once

#include <optional>
#include <string>

#include "server/http/service.h"

namespace lodestream::http {

inline constexpr std::size_t least_packed_bytes = 1024;  // below, head and packets are what costs
inline constexpr std::size_t most_packed_bytes = std::size_t{64} << 20;
inline constexpr std::uint64_t most_packed_file_bytes = 1u << 20;  // beyond, a GLB's JSON is next to nothing of it

// A whole answer, not a range of it.
bool takes_gzip(const Request& request);

// A text in `body` is packed where the client takes that. Says in `vary` that it depends on it.
void pack_body(Response& response, const Request& request);

// A GLB: its JSON deflated, the rest, which is compressed already, stored. Nothing where it cannot be read.
// pre: at most most_packed_file_bytes
std::optional<std::string> packed_glb(const store::StoredFile& file);

}  // namespace lodestream::http
