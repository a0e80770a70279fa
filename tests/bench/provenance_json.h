// Where and of what a benchmark measured, as the report reads it back (proto::RunOrigin).
#pragma once

#include <nlohmann/json.hpp>

#include "client/report/machine.h"

namespace lodestream::bench {

inline nlohmann::json provenance_json(const std::string& command_line) {
    const report::Provenance from = report::provenance_of(command_line);
    return {{"command", from.command},
            {"commit", from.commit},
            {"date", from.date},
            {"cpu", from.cpu},
            {"cores", from.cores}};
}

}  // namespace lodestream::bench
