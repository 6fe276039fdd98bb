// Chooses the length of a window of the drive's channel: one period, or two if one has too few samples for the fit. It
// never shortens again, since only windows of one length can be compared.
#pragma once

#include <cstdint>

namespace dwell {

// Bound to one thread, real-time safe.
class WindowLength {
 public:
  enum class Kind : std::uint8_t { one_period, two_periods, too_few_samples };

  [[nodiscard]] Kind kind() const noexcept { return kind_; }
  [[nodiscard]] int periods() const noexcept { return kind_ == Kind::one_period ? 1 : 2; }
  // Whether two periods have too few samples as well: nothing can be judged then.
  [[nodiscard]] bool too_few() const noexcept { return kind_ == Kind::too_few_samples; }

  // A window could be fitted.
  void fitted() noexcept {
    if (too_few()) kind_ = Kind::two_periods;
  }
  // A window could not be fitted: take two periods. If these have samples, the samples are too few.
  void not_fitted(bool has_samples) noexcept {
    if (kind_ == Kind::one_period)
      lengthen();
    else
      kind_ = has_samples ? Kind::too_few_samples : Kind::two_periods;
  }
  // Takes two periods because another channel has too few samples in one.
  void lengthen() noexcept {
    if (kind_ == Kind::one_period) kind_ = Kind::two_periods;
  }

 private:
  Kind kind_ = Kind::one_period;
};

}  // namespace dwell
