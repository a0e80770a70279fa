#include "client/report/server_process.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <iterator>
#include <thread>
#include <utility>
#include <vector>

namespace lodestream::report {
namespace {

using Clock = std::chrono::steady_clock;
constexpr auto poll_interval = std::chrono::milliseconds(20);

Clock::time_point deadline_in(double seconds) {
    return Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

std::string read_text(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

std::string last_line(std::string text) {
    text.erase(text.find_last_not_of(" \r\n") + 1);
    return text.substr(text.rfind('\n') + 1);
}

Result<std::filesystem::path> make_temporary_folder() {
    std::error_code error;
    std::string pattern = (std::filesystem::temp_directory_path(error) / "lodestream-report-XXXXXX").string();
    if (error || !mkdtemp(pattern.data()))
        return fail(ErrorCode::io, "cannot make a temporary folder for the server's store");
    return std::filesystem::path(pattern);
}

// Runs in the child: only calls that are safe between fork and exec.
[[noreturn]] void become(char* const* arguments, const char* output) {
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    const int file = open(output, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
    const int null = open("/dev/null", O_RDONLY | O_CLOEXEC);
    if (file >= 0 && null >= 0 && dup2(null, STDIN_FILENO) >= 0 && dup2(file, STDOUT_FILENO) >= 0 &&
        dup2(file, STDERR_FILENO) >= 0)
        execv(arguments[0], arguments);
    _exit(127);
}

bool has_ended(pid_t pid) {
    return waitpid(pid, nullptr, WNOHANG) != 0;
}

void stop(pid_t pid) {
    kill(pid, SIGTERM);
    for (const auto deadline = deadline_in(server_stop_timeout_s); Clock::now() < deadline;) {
        if (has_ended(pid)) return;
        std::this_thread::sleep_for(poll_interval);
    }
    kill(pid, SIGKILL);
    waitpid(pid, nullptr, 0);
}

}  // namespace

std::string find_address(const std::string& output) {
    constexpr std::string_view mark = "listening on ";
    const std::size_t at = output.starts_with(mark) ? 0 : output.find(std::string("\n").append(mark));
    if (at == std::string::npos) return "";
    const std::size_t begin = output.find(mark, at) + mark.size();
    const std::size_t end = output.find('\n', begin);
    return end == std::string::npos ? "" : output.substr(begin, end - begin);
}

std::filesystem::path server_beside_this_program() {
    std::error_code error;
    return std::filesystem::read_symlink("/proc/self/exe", error).parent_path() / "lodestream-server";
}

Result<ServerProcess> ServerProcess::start(const std::filesystem::path& program,
                                           const std::optional<std::filesystem::path>& assets) {
    if (access(program.c_str(), X_OK) != 0)
        return fail(ErrorCode::not_found,
                    "no server program at " + program.string() + "; name a running one with --server URL");
    Result<std::filesystem::path> folder = make_temporary_folder();
    if (!folder) return folder.error();
    ServerProcess server;
    server.folder_ = *folder;

    std::vector<std::string> words = {
        program.string(), "serve", "--listen", "127.0.0.1:0", "--store", (*folder / "store").string(), "--samples"};
    if (assets) words.insert(words.end(), {"--assets", assets->string()});
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    const std::string output = (*folder / "output.txt").string();

    server.pid_ = fork();
    if (server.pid_ < 0) return fail(ErrorCode::io, "cannot start " + program.string());
    if (server.pid_ == 0) become(arguments.data(), output.c_str());
    if (Status listening = server.wait_for_address(); !listening) return listening.error();
    return server;
}

Status ServerProcess::wait_for_address() {
    const std::filesystem::path output = folder_ / "output.txt";
    for (const auto deadline = deadline_in(server_start_timeout_s); Clock::now() < deadline;) {
        url_ = find_address(read_text(output));
        if (!url_.empty()) return Nothing{};
        if (has_ended(pid_)) {
            pid_ = -1;
            return fail(ErrorCode::unavailable, "the server ended at once: " + last_line(read_text(output)));
        }
        std::this_thread::sleep_for(poll_interval);
    }
    return fail(ErrorCode::unavailable, "the server named no address: " + last_line(read_text(output)));
}

ServerProcess::ServerProcess(ServerProcess&& other) noexcept
    : pid_(std::exchange(other.pid_, -1)), folder_(std::exchange(other.folder_, {})), url_(std::move(other.url_)) {}

ServerProcess::~ServerProcess() {
    if (pid_ > 0) stop(pid_);
    std::error_code ignored;
    if (!folder_.empty()) std::filesystem::remove_all(folder_, ignored);
}

}  // namespace lodestream::report
