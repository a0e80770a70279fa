// Plans and contents once more over links throttled for real, each over a connection of its own.
#pragma once

#include <string>

#include "client/report/data.h"

namespace lodestream::report {

// What would take longer than this to transfer, by its bytes alone, is left out.
inline constexpr double max_link_s = 20.0, max_quick_link_s = 4.0;
// So many transfers run at once that their links carry this together: they shall not wait for the machine.
inline constexpr double mbps_at_once = 20.0;

// Sets linked_plan_ms and linked_fetch_ms of everything that was measured. `server_url`: the server that it came from.
// Errors: the first of any transfer.
Status measure_links(const std::string& server_url, double max_s, std::vector<AssetResult>& assets);

}  // namespace lodestream::report
