// What the commands read from files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "common/base/result.h"
#include "proto/messages.h"

namespace lodestream::client {

// `what` names the limit's error: "a motion". Errors: io, limit_exceeded; the file is named.
Result<std::string> read_text(const std::filesystem::path& path, std::uintmax_t max_bytes, const std::string& what);

// What a device says of itself, as a plan request takes it. Errors: those of read_text(), invalid_input (the file and
// the field are named).
Result<proto::PlanRequest> read_device_file(const std::filesystem::path& path);

}  // namespace lodestream::client
