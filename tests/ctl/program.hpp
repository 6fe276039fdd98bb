// dwellctl as its users see it: the program is started, its exit code and both its outputs are looked at.
#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "tests/ctl/temporary.hpp"

namespace dwell::test {

struct Outcome {
  int code = -1;
  std::string out;
  std::string err;
};

inline std::string contents(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

// Starts dwellctl; its outputs go to files, so that neither can block it.
class Program {
 public:
  explicit Program(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), DWELLCTL);
    std::vector<char*> pointers;
    pointers.reserve(arguments.size() + 1);
    for (std::string& argument : arguments) pointers.push_back(argument.data());
    pointers.push_back(nullptr);
    const std::string out = folder_.path("out");
    const std::string err = folder_.path("err");
    process_ = ::fork();
    if (process_ == 0) {
      if (std::freopen(out.c_str(), "w", stdout) == nullptr || std::freopen(err.c_str(), "w", stderr) == nullptr)
        _exit(99);
      ::unsetenv("DWELL_URL");
      ::unsetenv("DWELL_CONTROL");
      ::execv(DWELLCTL, pointers.data());
      _exit(98);
    }
  }
  ~Program() {
    if (process_ > 0) (void)wait();
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  void interrupt() const { ::kill(process_, SIGINT); }
  [[nodiscard]] std::string out() const { return contents(folder_.path("out")); }

  Outcome wait() {
    int status = 0;
    ::waitpid(process_, &status, 0);
    process_ = -1;
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, out(), contents(folder_.path("err"))};
  }

 private:
  TemporaryFolder folder_;
  pid_t process_ = -1;
};

inline Outcome run(const std::vector<std::string>& arguments) { return Program(arguments).wait(); }

}  // namespace dwell::test
