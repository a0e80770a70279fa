// A device file of the command line: what this device says of itself, as a plan request takes it.
#pragma once

#include <filesystem>

#include "common/base/result.h"
#include "proto/messages.h"

namespace lodestream::client {

// Errors: io, limit_exceeded, invalid_input (the file and the field are named).
Result<proto::PlanRequest> read_device_file(const std::filesystem::path& path);

}  // namespace lodestream::client
