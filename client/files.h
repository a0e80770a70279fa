// What the commands read from files and write to them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "common/base/result.h"
#include "common/motion/motion.h"
#include "proto/messages.h"

namespace lodestream::client {

// `what` names the limit's error: "a motion". Errors: io, limit_exceeded; the file is named.
Result<std::string> read_text(const std::filesystem::path& path, std::uintmax_t max_bytes, const std::string& what);

// What a device says of itself, as a plan request takes it. Errors: those of read_text(), invalid_input (the file and
// the field are named).
Result<proto::PlanRequest> read_device_file(const std::filesystem::path& path);

// A CSV file, or "builtin:NAME" of common/motion. Errors: those of read_text(), invalid_input (the file is named).
Result<motion::Trace> read_motion(const std::string& motion);

// Errors: io; the path is named.
Status write_text(const std::filesystem::path& path, const std::string& text);
Status make_folder(const std::filesystem::path& folder);

// folder/000000.png and so on.
std::filesystem::path numbered_png(const std::filesystem::path& folder, std::size_t number);

}  // namespace lodestream::client
