#include "serve.h"

#include "deformable_surface/base/parallel.h"

#include "kept_surfaces.h"
#include "simulate.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

namespace deformable_surface::node {
namespace {

constexpr int kWrongRequest = 2;

// The arguments of the next request; none at the end of the input.
class Requests {
 public:
  explicit Requests(int in) : in_(in) {}

  std::optional<std::vector<std::string>> read() {
    std::vector<std::string> arguments;
    while (true) {
      std::size_t end;
      while ((end = buffer_.find('\0')) == std::string::npos) {
        char bytes[4096];
        const ssize_t count = ::read(in_, bytes, sizeof bytes);
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) return std::nullopt;
        buffer_.append(bytes, static_cast<std::size_t>(count));
      }
      std::string argument = buffer_.substr(0, end);
      buffer_.erase(0, end + 1);
      if (argument.empty()) return arguments;
      arguments.push_back(std::move(argument));
    }
  }

 private:
  int in_;
  std::string buffer_;
};

// Lets a descriptor write to a file of the run's folder.
bool redirect(int descriptor, const char* file) {
  const int opened = open(file, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  return opened >= 0 && dup2(opened, descriptor) >= 0 && close(opened) == 0;
}

// Runs in the copy of the process.
int runHere(const std::vector<std::string>& arguments, KeptSurfaces& kept) {
  std::signal(SIGINT, SIG_DFL);
  if (chdir(arguments[0].c_str()) != 0 || !redirect(STDOUT_FILENO, "out") || !redirect(STDERR_FILENO, "err"))
    return kWrongRequest;
  const StopSignal never;
  const int status = simulate({arguments.begin() + 1, arguments.end()}, {std::cout, std::cerr, false, never}, &kept);
  std::cout.flush();
  std::cerr.flush();
  return status;
}

std::string describeStatus(int status) {
  return WIFSIGNALED(status) ? "signal " + std::to_string(WTERMSIG(status)) : std::to_string(WEXITSTATUS(status));
}

// The status of a run; none if the caller has gone meanwhile.
std::optional<int> awaitRun(pid_t child, int in, int alive) {
  pollfd watched[] = {{alive, POLLIN, 0}, {in, 0, 0}};
  while (true) {
    if (poll(watched, 2, -1) < 0) {
      if (errno == EINTR) continue;
      return std::nullopt;
    }
    if (watched[0].revents != 0) break;  // its end of the pipe is closed
    if (watched[1].revents != 0) {
      kill(child, SIGKILL);
      return std::nullopt;
    }
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return std::nullopt;
  return status;
}

}  // namespace

int serve(int in, int out) {
  setNumThreads(1);  // others would be lost to the copies
  Requests requests(in);
  KeptSurfaces kept;
  while (const auto arguments = requests.read()) {
    if (arguments->size() < 2) return kWrongRequest;
    // Here, so that the next copies have it, too.
    prepare({arguments->begin() + 1, arguments->end()}, kept);
    int alive[2];
    if (pipe2(alive, O_CLOEXEC) != 0) return kWrongRequest;
    const pid_t server = getpid();
    const pid_t child = fork();
    if (child < 0) return kWrongRequest;
    if (child == 0) {
      // The run ends if the server is killed, even before this call.
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      if (getppid() != server) _exit(kWrongRequest);
      _exit(runHere(*arguments, kept));
    }
    close(alive[1]);
    const std::optional<int> status = awaitRun(child, in, alive[0]);
    close(alive[0]);
    if (!status) return kWrongRequest;
    const std::string answer = describeStatus(*status) + "\n";
    if (write(out, answer.data(), answer.size()) != static_cast<ssize_t>(answer.size())) return kWrongRequest;
  }
  return 0;
}

}  // namespace deformable_surface::node
