// A server of our own for the length of one report: started beside this program on a free loopback port with a
// temporary store, stopped and cleaned up at the end.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>

#include "common/base/result.h"

namespace lodestream::report {

inline constexpr double server_start_timeout_s = 60.0;
inline constexpr double server_stop_timeout_s = 20.0;  // then it is killed

class ServerProcess {
  public:
    // Starts `program serve --listen 127.0.0.1:0 --store <temporary> --samples [--assets DIR]` and waits for its
    // address. Errors: not_found (no program), io, unavailable (it ended or said nothing; with its last line).
    static Result<ServerProcess> start(const std::filesystem::path& program,
                                       const std::optional<std::filesystem::path>& assets);
    ServerProcess(ServerProcess&& other) noexcept;
    ServerProcess& operator=(ServerProcess&&) = delete;
    ~ServerProcess();

    const std::string& url() const { return url_; }  // "http://127.0.0.1:PORT"

  private:
    ServerProcess() = default;
    Status wait_for_address();

    pid_t pid_ = -1;
    std::filesystem::path folder_;  // the store and the server's output
    std::string url_;
};

// The address after "listening on " at the start of a line; empty where there is none yet.
std::string find_address(const std::string& output);

// `lodestream-server` beside the running program.
std::filesystem::path server_beside_this_program();

}  // namespace lodestream::report
