#include "daemon/ctl/progress.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

namespace dwell::ctl {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kFirst{500};  // shorter work needs no bar
constexpr milliseconds kEvery{100};
constexpr int kLongestBar = 40;     // columns
constexpr int kShortestBar = 5;     // columns; below that only the figures are shown
constexpr double kTellable = 0.02;  // share of the work before the time left is shown

int terminal_width() {
  winsize size{};
  return ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

std::string time_left(double part, double elapsed_s) {
  if (part < kTellable || elapsed_s <= 0.0) return "";
  const auto left_s = static_cast<long>(std::ceil(elapsed_s * (1.0 - part) / part));
  if (left_s < 120) return std::to_string(left_s) + " s left";
  if (left_s < 7200) return std::to_string((left_s + 30) / 60) + " min left";
  return std::to_string((left_s + 1800) / 3600) + " h left";
}

}  // namespace

std::string progress_line(std::string_view what, double part, double elapsed_s, int width) {
  part = std::isfinite(part) ? std::clamp(part, 0.0, 1.0) : 0.0;
  char percent[8];
  std::snprintf(percent, sizeof percent, "%3d %%", static_cast<int>(100.0 * part));
  std::string left = time_left(part, elapsed_s);
  if (!left.empty()) left = "  " + left;
  const int figures = static_cast<int>(what.size() + 2 + 5 + left.size());
  const int columns = std::min(width - figures - 1, kLongestBar);
  std::string bar;
  if (columns >= kShortestBar) {
    const int done = static_cast<int>(part * columns);
    for (int i = 0; i < columns; ++i) bar += i < done ? "█" : "·";
    bar += " ";
  }
  std::string line = std::string(what) + "  " + bar + percent + left;
  // Too narrow even for the figures: the percentage alone.
  if (columns < kShortestBar && figures > width) line = percent;
  return line;
}

ProgressBar::ProgressBar(std::string what)
    : what_(std::move(what)), there_(::isatty(STDERR_FILENO) != 0), next_(begin_ + kFirst) {}

ProgressBar::~ProgressBar() {
  if (drawn_) std::fputs("\r\x1b[K", stderr);
}

void ProgressBar::show(double part) {
  if (!there_) return;
  const Clock::time_point now = Clock::now();
  if (now < next_) return;
  next_ = now + kEvery;
  drawn_ = true;
  const double elapsed_s = std::chrono::duration<double>(now - begin_).count();
  std::fprintf(stderr, "\r%s\x1b[K", progress_line(what_, part, elapsed_s, terminal_width() - 1).c_str());
}

Progress ProgressBar::progress() {
  if (!there_) return {};
  return [this](double part) { show(part); };
}

}  // namespace dwell::ctl
