// Real programs for tests over real sockets.
#pragma once

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <vector>

namespace lodestream::testing {

// A started program whose standard output is read; killed with its object, and with a test that dies.
class Program {
  public:
    Program(std::string file, std::vector<std::string> arguments) {
        std::vector<char*> argv{file.data()};
        for (std::string& argument : arguments) argv.push_back(argument.data());
        argv.push_back(nullptr);
        int ends[2];
        if (::pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
        pid_ = ::fork();
        if (pid_ == 0) {
            ::prctl(PR_SET_PDEATHSIG, SIGKILL);
            ::dup2(ends[1], STDOUT_FILENO);
            ::execv(argv[0], argv.data());
            ::_exit(127);
        }
        ::close(ends[1]);
        output_ = ::fdopen(ends[0], "r");
    }
    ~Program() {
        if (pid_ > 0) {
            ::kill(pid_, SIGKILL);
            wait();
        }
        std::fclose(output_);
    }
    Program(const Program&) = delete;
    Program& operator=(const Program&) = delete;

    std::string read_line() {
        std::string line;
        for (int c = std::fgetc(output_); c != EOF && c != '\n'; c = std::fgetc(output_)) line += static_cast<char>(c);
        return line;
    }
    pid_t pid() const { return pid_; }
    void signal(int number) const { ::kill(pid_, number); }
    // The exit code, or minus the signal that ended it.
    int wait() {
        int status = 0;
        ::waitpid(pid_, &status, 0);
        pid_ = -1;
        return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
    }

  private:
    pid_t pid_ = -1;
    std::FILE* output_ = nullptr;
};

// `lodestream-server serve` on a free port of this machine.
class ServerProgram : public Program {
  public:
    ServerProgram(std::string file, const std::string& store, const std::vector<std::string>& more = {})
        : Program(std::move(file), arguments(store, more)) {
        const std::string banner = read_line(), prefix = "listening on ";
        if (!banner.starts_with(prefix + "http://")) throw std::runtime_error("the server said \"" + banner + "\"");
        url = banner.substr(prefix.size());
        url.erase(url.find_last_not_of(' ') + 1);
    }

    std::string url;

  private:
    static std::vector<std::string> arguments(const std::string& store, const std::vector<std::string>& more) {
        std::vector<std::string> all{"serve", "--listen", "127.0.0.1:0", "--store", store};
        all.insert(all.end(), more.begin(), more.end());
        return all;
    }
};

}  // namespace lodestream::testing
