#include "daemon/record/anchor_delivery.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "daemon/record/small_file.hpp"

namespace dwell::record {
namespace {

// Attributes and file actions of a child: a process group of its own, the default signals, standard input from `input`.
class ChildSetup {
 public:
  explicit ChildSetup(int input) {
    posix_spawnattr_init(&attributes_);
    posix_spawn_file_actions_init(&actions_);
    sigset_t none, all;
    sigemptyset(&none);
    sigfillset(&all);
    posix_spawnattr_setsigmask(&attributes_, &none);
    posix_spawnattr_setsigdefault(&attributes_, &all);
    posix_spawnattr_setpgroup(&attributes_, 0);
    posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
    posix_spawn_file_actions_adddup2(&actions_, input, STDIN_FILENO);
    posix_spawn_file_actions_addopen(&actions_, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  }
  ~ChildSetup() {
    posix_spawn_file_actions_destroy(&actions_);
    posix_spawnattr_destroy(&attributes_);
  }
  ChildSetup(const ChildSetup&) = delete;
  ChildSetup& operator=(const ChildSetup&) = delete;

  // An errno, or 0.
  int spawn(std::vector<std::string> command, pid_t& child) const {
    std::vector<char*> arguments;
    for (std::string& argument : command) arguments.push_back(argument.data());
    arguments.push_back(nullptr);
    return posix_spawnp(&child, arguments[0], &actions_, &attributes_, arguments.data(), environ);
  }

 private:
  posix_spawnattr_t attributes_;
  posix_spawn_file_actions_t actions_;
};

std::string exit_text(int status) {
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return {};
  if (WIFEXITED(status)) return "exit status " + std::to_string(WEXITSTATUS(status));
  return std::string("ended by ") + strsignal(WTERMSIG(status));
}

// Whether the child ends within `limit`.
bool ends_within(pid_t child, std::chrono::milliseconds limit) {
  const int handle = static_cast<int>(syscall(SYS_pidfd_open, child, 0));
  if (handle < 0) return false;
  using Clock = std::chrono::steady_clock;
  const auto until = Clock::now() + limit;
  pollfd ended{handle, POLLIN, 0};
  int ready = -1;
  do {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now());
    ready = poll(&ended, 1, static_cast<int>(std::max<std::int64_t>(left.count(), 0)));
  } while (ready < 0 && errno == EINTR);
  close(handle);
  return ready > 0;
}

// Empty: it succeeded.
std::string await_child(pid_t child, std::chrono::milliseconds limit) {
  const bool late = !ends_within(child, limit);
  if (late) kill(-child, SIGKILL);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (late) {
    char text[48];
    std::snprintf(text, sizeof text, "not done within %g s", static_cast<double>(limit.count()) * 1e-3);
    return text;
  }
  return exit_text(status);
}

Result<void> run_command(const std::vector<std::string>& command, const std::string& lines,
                         std::chrono::milliseconds limit) {
  const std::string name = "command " + command.front() + ": ";
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return tl::unexpected(name + std::strerror(errno));
  pid_t child = 0;
  const int error = ChildSetup(ends[0]).spawn(command, child);
  // A pipe holds far more than a few lines, so this never waits. Our own reading end is open, so it raises no SIGPIPE.
  // A command need not read the lines.
  [[maybe_unused]] const auto written = write(ends[1], (lines + "\n").data(), lines.size() + 1);
  close(ends[0]);
  close(ends[1]);
  if (error != 0) return tl::unexpected(name + std::strerror(error));
  if (const std::string failed = await_child(child, limit); !failed.empty()) return tl::unexpected(name + failed);
  return {};
}

}  // namespace

Result<void> deliver_anchor(const AnchorTarget& target, const std::string& lines, std::chrono::milliseconds limit) {
  Result<void> done;
  if (!target.file.empty()) done = append_line(target.file, lines);
  if (!target.command.empty()) {
    if (auto ran = run_command(target.command, lines, limit); !ran) done = ran;
  }
  return done;
}

}  // namespace dwell::record
