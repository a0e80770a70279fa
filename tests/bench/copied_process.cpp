#include "tests/bench/copied_process.h"

#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <exception>
#include <iostream>
#include <memory>
#include <stdexcept>

namespace lodestream::bench {

namespace {

struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, Close>;

File opened(int pipe_end, const char* mode) {
    File file(fdopen(pipe_end, mode));
    if (!file) throw std::runtime_error("no stream for a pipe");
    std::setvbuf(file.get(), nullptr, _IONBF, 0);
    return file;
}

[[noreturn]] void live_as_copy(const std::function<void(std::FILE*)>& write, int pipe_end) {
    int code = 1;
    try {
        write(opened(pipe_end, "w").get());
        code = 0;
    } catch (const std::exception& error) {
        std::cerr << error.what() << std::endl;
    }
    _exit(code);
}

}  // namespace

void run_in_copy(const std::function<void(std::FILE*)>& write, const std::function<void(std::FILE*)>& read) {
    std::array<int, 2> ends{};
    if (pipe(ends.data()) != 0) throw std::runtime_error("no pipe");
    const pid_t copy = fork();
    if (copy < 0) throw std::runtime_error("no second process");
    if (copy == 0) {
        close(ends[0]);
        live_as_copy(write, ends[1]);
    }
    close(ends[1]);
    bool complete = true;
    try {
        read(opened(ends[0], "r").get());
    } catch (const std::runtime_error&) {
        complete = false;
    }
    int status = 0;
    waitpid(copy, &status, 0);
    if (!complete || status != 0) throw std::runtime_error("work in a copy of this process failed");
}

void send_bytes(const void* bytes, std::size_t size, std::FILE* to) {
    if (std::fwrite(bytes, 1, size, to) != size) throw std::runtime_error("nobody reads the pipe");
}

void receive_bytes(void* bytes, std::size_t size, std::FILE* from) {
    if (std::fread(bytes, 1, size, from) != size) throw std::runtime_error("the pipe ended early");
}

}  // namespace lodestream::bench
