// How far long work is, as a bar on the terminal: "replaying  ██████····  61 %  3 s left". Shared by all verbs.
#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <string_view>

namespace dwell::ctl {

// Called now and then with the share of the work that is done, 0 … 1. Empty: not wanted.
using Progress = std::function<void(double)>;

// One line, without the carriage return, at most `width` columns wide. elapsed_s: since the work began.
[[nodiscard]] std::string progress_line(std::string_view what, double part, double elapsed_s, int width);

// The bar. It stands on standard error and only if that is a terminal. It appears once the work has taken half a
// second, is drawn at most ten times a second, and is gone when the object is destroyed. Bound to one thread.
class ProgressBar {
 public:
  // what: the work in one word or two, "replaying".
  explicit ProgressBar(std::string what);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  // part: 0 … 1. Cheap enough to call for every record: it reads the clock and seldom writes.
  void show(double part);
  // The same as a function, valid as long as the bar; empty where there is no terminal.
  [[nodiscard]] Progress progress();

 private:
  using Clock = std::chrono::steady_clock;

  std::string what_;
  bool there_;
  bool drawn_ = false;
  Clock::time_point begin_ = Clock::now();
  Clock::time_point next_;
};

}  // namespace dwell::ctl
