// How long a window of the drive's channel is, in periods: one, or two where one alone has too few samples for the fit.
// Never shorter again: what is compared with each other must be of one length.
#pragma once

#include <cstdint>

namespace dwell {

// Bound to one thread, real-time safe.
class WindowLength {
 public:
  enum class Kind : std::uint8_t { one_period, two_periods, too_few_samples };

  [[nodiscard]] Kind kind() const noexcept { return kind_; }
  [[nodiscard]] int periods() const noexcept { return kind_ == Kind::one_period ? 1 : 2; }
  // Two periods have too few samples as well: nothing can be judged.
  [[nodiscard]] bool too_few() const noexcept { return kind_ == Kind::too_few_samples; }

  // A window could be fitted.
  void fitted() noexcept {
    if (too_few()) kind_ = Kind::two_periods;
  }
  // It could not: look at two periods; where these had samples, they are too few.
  void not_fitted(bool has_samples) noexcept {
    if (kind_ == Kind::one_period)
      lengthen();
    else
      kind_ = has_samples ? Kind::too_few_samples : Kind::two_periods;
  }
  // Another channel has too few samples in one period.
  void lengthen() noexcept {
    if (kind_ == Kind::one_period) kind_ = Kind::two_periods;
  }

 private:
  Kind kind_ = Kind::one_period;
};

}  // namespace dwell
