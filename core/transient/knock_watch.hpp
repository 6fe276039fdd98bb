// Watches each quarter of a period for a knock while the rig settles, and keeps since when the rig has swung freely. A
// knock begins the natural oscillations anew; the drive and the poles stay as they are.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/transient/hold_fit.hpp"
#include "core/transient/hold_now.hpp"
#include "core/transient/residual_noise.hpp"

namespace dwell {

// Bound to one thread. No allocation but in the constructor. Instants in ns.
class KnockWatch {
 public:
  explicit KnockWatch(int channels) : newest_(static_cast<std::size_t>(channels)) {}

  void begin_hold(std::int64_t steady_ns) noexcept;

  // Whether the residuals since from_ns, the newest quarter of a period, exceed the noise. The fit must have explained
  // all samples before. O(samples since).
  [[nodiscard]] bool sees_knock(HoldFit& fit, const ResidualNoise& noise, const HoldNow& now,
                                std::int64_t from_ns) noexcept;
  // Notes a knock in the quarter that ends at end_ns; the next refit looks at it.
  void alarm(std::int64_t end_ns) noexcept;
  // The fit explains all: there was no knock, or the fit begins after it.
  void clear_alarm() noexcept { alarm_ns_.reset(); }
  // The newest alarm that has not been cleared.
  [[nodiscard]] const std::optional<std::int64_t>& alarm_ns() const noexcept { return alarm_ns_; }
  // Whether an alarm came after t that has not been cleared.
  [[nodiscard]] bool alarmed_since(std::int64_t t_ns) const noexcept { return alarm_ns_ && *alarm_ns_ > t_ns; }
  // Whether there was an alarm in this hold.
  [[nodiscard]] bool any() const noexcept { return any_; }

  // Since when the natural oscillations have gone on undisturbed: the hold's beginning, or the last knock found.
  [[nodiscard]] std::int64_t free_since_ns() const noexcept { return free_since_ns_; }
  void set_free_since(std::int64_t t_ns) noexcept { free_since_ns_ = t_ns; }

 private:
  struct Newest {
    double squares = 0.0, count = 0.0;
  };
  std::vector<Newest> newest_;  // per channel, residuals of the newest quarter
  std::int64_t free_since_ns_ = 0;
  std::optional<std::int64_t> alarm_ns_;
  bool any_ = false;
};

}  // namespace dwell
