#include "tests/rigsim/sync_pulses.hpp"

#include <fcntl.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>

#include "drivers/dwell_driver.hpp"
#include "tests/rigsim/device.hpp"

namespace rigsim {
namespace {

double number_of(const std::string& status, const std::string& key) {
  const auto at = status.find("\"" + key + "\":");
  if (at == std::string::npos) return 0.0;
  const auto first = at + key.size() + 3;
  return number(status.substr(first, status.find_first_of(",}", first) - first)).value_or(0.0);
}

}  // namespace

SyncState sync_state(const std::string& status) {
  const bool running = status.find("\"running\":true") != std::string::npos;
  return {running ? number_of(status, "frequency_hz") : 0.0, number_of(status, "sync_missing"),
          number_of(status, "sync_twice")};
}

tl::expected<std::unique_ptr<SyncPulses>, std::string> SyncPulses::start(const SyncOptions& options, Server& server) {
  Fd file(::open(options.file.c_str(), O_WRONLY | O_CLOEXEC));
  if (!file) return tl::make_unexpected("cannot write " + options.file + ": " + std::strerror(errno));
  return std::unique_ptr<SyncPulses>(new SyncPulses(options, server, std::move(file)));
}

SyncPulses::SyncPulses(const SyncOptions& options, Server& server, Fd file)
    : options_(options), server_(server), file_(std::move(file)), random_(options.seed), thread_([this] { run(); }) {}

SyncPulses::~SyncPulses() {
  stop_ = true;
  thread_.join();
}

void SyncPulses::run() {
  constexpr double kIdle_s = 0.02;
  std::uniform_real_distribution<double> chance;
  double next_s = server_.simulated_time_s(dwell::driver::raw_ns());
  while (true) {
    const SyncState state = sync_state(server_.command("status"));
    const double period_s = state.frequency_hz > 0.0 ? 1.0 / state.frequency_hz : kIdle_s;
    if (state.frequency_hz > 0.0) {
      const double length_s = std::min(0.1 * period_s, 0.01);
      if (chance(random_) >= state.missing && !pulse(next_s, length_s)) return;
      if (chance(random_) < state.twice && !pulse(next_s + 0.25 * period_s, length_s)) return;
    }
    next_s += period_s;
    if (!wait_until(next_s - 0.5 * period_s)) return;
  }
}

bool SyncPulses::pulse(double at_s, double length_s) {
  if (!wait_until(at_s)) return false;
  level(true);
  const bool on = wait_until(at_s + length_s);
  level(false);
  return on;
}

bool SyncPulses::wait_until(double t_s) {
  constexpr double kLongestWait_s = 0.05;
  while (!stop_) {
    const double left_s = t_s - server_.simulated_time_s(dwell::driver::raw_ns());
    if (left_s <= 0.0) return true;
    const auto wait_ns = static_cast<long>(std::min(left_s, kLongestWait_s) * 1e9);
    const timespec wait{0, wait_ns};
    ::nanosleep(&wait, nullptr);
  }
  return false;
}

void SyncPulses::level(bool high) {
  const std::string word = high ? "pull-up\n" : "pull-down\n";
  [[maybe_unused]] const auto written = ::pwrite(file_.get(), word.data(), word.size(), 0);
  if (written < 0 && errno == ESPIPE) [[maybe_unused]]
    const auto to_pipe = ::write(file_.get(), word.data(), word.size());
}

}  // namespace rigsim
