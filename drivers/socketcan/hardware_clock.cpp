#include "drivers/socketcan/hardware_clock.hpp"

#include <algorithm>
#include <cmath>

namespace dwell::socketcan {
namespace {

constexpr std::int64_t kWindow_ns = 1'000'000'000;
// A frame cannot be stamped by the kernel before it came; what is worse than noise is another clock than before.
constexpr std::int64_t kJump_ns = 2'000'000;
// No interface keeps a frame so long; its clock was set, or has stood still.
constexpr std::int64_t kLongest_ns = 100'000'000;
constexpr std::size_t kForSlope = 3;
constexpr double kSteepest = 1e-3;
// Stamps beyond that are not of this world, and differences of them would overflow.
constexpr std::int64_t kFarthest_ns = INT64_MAX / 4;

}  // namespace

void HardwareClock::begin(const Point& point) noexcept {
  *this = HardwareClock();
  begun_ = true;
  anchor_ = window_ = point;
  window_ns_ = last_ns_ = point.x_ns;
  window_empty_ = false;
}

std::int64_t HardwareClock::line_ns(std::int64_t x_ns) const noexcept {
  return anchor_.d_ns + static_cast<std::int64_t>(slope_ * static_cast<double>(x_ns - anchor_.x_ns));
}

void HardwareClock::close_window() noexcept {
  if (window_empty_) return;
  least_[next_] = window_;
  next_ = (next_ + 1) % kWindows;
  count_ = std::min(count_ + 1, kWindows);
  window_empty_ = true;
  // Relative to the newest point, where the line is used.
  const Point origin = window_;
  double sum_x = 0, sum_d = 0, sum_xx = 0, sum_xd = 0;
  const auto n = static_cast<double>(count_);
  for (std::size_t i = 0; i < count_; ++i) {
    const auto x = static_cast<double>(least_[i].x_ns - origin.x_ns),
               d = static_cast<double>(least_[i].d_ns - origin.d_ns);
    sum_x += x, sum_d += d, sum_xx += x * x, sum_xd += x * d;
  }
  const double spread = n * sum_xx - sum_x * sum_x;
  slope_ = count_ >= kForSlope && spread > 0.0
               ? std::clamp((n * sum_xd - sum_x * sum_d) / spread, -kSteepest, kSteepest)
               : 0.0;
  double lowest = 0.0;
  for (std::size_t i = 0; i < count_; ++i)
    lowest = std::min(lowest, static_cast<double>(least_[i].d_ns - origin.d_ns) -
                                  slope_ * static_cast<double>(least_[i].x_ns - origin.x_ns));
  anchor_ = {origin.x_ns, origin.d_ns + static_cast<std::int64_t>(count_ >= kForSlope ? lowest : 0.0)};
}

std::optional<std::int64_t> HardwareClock::map(std::int64_t hardware_ns,
                                               std::optional<std::int64_t> kernel_ns) noexcept {
  if (hardware_ns <= 0 || hardware_ns > kFarthest_ns) return std::nullopt;
  if (!kernel_ns) {
    if (!begun_ || std::abs(hardware_ns - last_ns_) > 2 * kWindow_ns) return std::nullopt;
    return hardware_ns + line_ns(hardware_ns);
  }
  const Point point{hardware_ns, *kernel_ns - hardware_ns};
  const std::int64_t above_ns = point.d_ns - line_ns(hardware_ns);
  if (!begun_ || above_ns < -kJump_ns || above_ns > kLongest_ns || hardware_ns < last_ns_ - kWindow_ns) {
    begin(point);
    return std::nullopt;
  }
  if (hardware_ns - window_ns_ >= kWindow_ns) {
    close_window();
    window_ns_ = hardware_ns;
  }
  last_ns_ = std::max(last_ns_, hardware_ns);
  if (window_empty_ || point.d_ns < window_.d_ns) window_ = point;
  window_empty_ = false;
  if (const std::int64_t below_ns = line_ns(hardware_ns) - point.d_ns; below_ns > 0) anchor_.d_ns -= below_ns;
  return std::min(hardware_ns + line_ns(hardware_ns), *kernel_ns);
}

}  // namespace dwell::socketcan
