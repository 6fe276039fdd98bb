// dwellctl started as a program of its own: its exit code and both its outputs. And a small rig with its recording.
#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <numbers>
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

inline constexpr const char* kRig = R"([rig]
name = "mount"
boundary = "clamped"
masses = []
[excitation]
frequency = 4.0
minimum = 2e-5
[[device]]
name = "recording"
driver = "replay"
file = "data.csv"
[[channel]]
name = "y0"
device = "recording"
measures = "displacement"
at = 0
unit = "mm"
[[channel]]
name = "reaction"
device = "recording"
measures = "force"
at = "ground"
unit = "N"
)";

// 5 s of an element of 240 kN/m and 310 N·s/m at 4 Hz; or of nothing.
inline std::string recording(double amplitude_mm, const std::string& header) {
  constexpr double omega = 2.0 * std::numbers::pi * 4.0;
  std::string text = header + "\n";
  for (int i = 0; i < 1000; ++i) {
    const double t_s = i / 200.0;
    const double force =
        1e-3 * amplitude_mm * (240000.0 * std::sin(omega * t_s) + omega * 310.0 * std::cos(omega * t_s));
    std::array<char, 120> line{};
    std::snprintf(line.data(), line.size(), "%.6f,%.12g,%.12g\n", t_s, amplitude_mm * std::sin(omega * t_s), force);
    text += line.data();
  }
  return text;
}

}  // namespace dwell::test
