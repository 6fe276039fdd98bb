#include "tests/bench/simulated_rig.hpp"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdio>
#include <memory>

namespace dwell {

SimulatedRig::SimulatedRig(const std::string& program) {
  std::array<int, 2> pipe{};
  if (::pipe2(pipe.data(), O_CLOEXEC) != 0) return;
  process_ = ::fork();
  if (process_ == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGTERM);
    ::dup2(::open("/dev/null", O_RDONLY | O_CLOEXEC), STDIN_FILENO);
    ::dup2(pipe[1], STDOUT_FILENO);
    ::execl(program.c_str(), program.c_str(), "--tcp", "127.0.0.1:0", static_cast<char*>(nullptr));
    ::_exit(127);
  }
  ::close(pipe[1]);
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> lines(::fdopen(pipe[0], "r"), &std::fclose);
  std::array<char, 256> line{};
  while (lines && std::fgets(line.data(), line.size(), lines.get()) != nullptr) {
    if (std::sscanf(line.data(), "tcp 127.0.0.1:%d", &port_) == 1) return;
  }
}

SimulatedRig::~SimulatedRig() {
  if (process_ <= 0) return;
  ::kill(process_, SIGTERM);
  ::waitpid(process_, nullptr, 0);
}

}  // namespace dwell
