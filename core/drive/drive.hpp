// Detects a change of the drive from windows of the table's motion, which is imposed and has no transient of its own.
// A window's amplitude, and its frequency by the phase's advance over a period, are compared with the hold's reference.
#pragma once

#include <array>
#include <complex>

#include "core/fit/blocks.hpp"

namespace dwell {

class DriveMonitor {
 public:
  // tolerance: relative change of amplitude, beyond noise, that makes another drive; of frequency, 1.5 times as much.
  explicit DriveMonitor(double tolerance) noexcept : tolerance_(tolerance) {}

  // Begins a new hold. The mean of its first windows is the reference until refer().
  void restart() noexcept;
  // Makes the dwell's own fit the reference: amplitude (m, rad) and omega (rad/s).
  void refer(double amplitude, double omega) noexcept;
  // Amplitude of the reference, m (rad); 0 before the first window.
  [[nodiscard]] double amplitude() const noexcept { return amplitude_; }

  // Takes one window, a quarter of a period after the last. Y: the table's phasor about the window's centre, m (rad);
  // u: standard deviation of either component; omega: of the window's fit, rad/s. Returns true if this window and the
  // one before differ from the reference: one disturbed window alone is not enough. Real-time safe.
  bool update(double centre_s, std::complex<double> Y, double u, double omega) noexcept;

  // Angular frequency of the reference, rad/s, from the phase's advance; NaN before a period has passed.
  [[nodiscard]] double omega() const noexcept;
  // Windows since the last that agreed with the reference beyond doubt; 0: the newest does. When a change ends the
  // dwell, the data of these windows do not count.
  [[nodiscard]] int windows_since_good() const noexcept { return since_good_; }

 private:
  static constexpr long kReference = 64;  // windows of a hold in the mean that is its reference
  struct Window {
    double centre_s;
    std::complex<double> Y;
    double u;
  };
  double tolerance_;
  std::array<Window, kQuarters> last_{};
  long seen_ = 0;         // windows since restart
  long frequencies_ = 0;  // windows that gave a frequency
  double amplitude_ = 0.0, omega_ = 0.0;
  int suspicious_ = 0, since_good_ = 0;
};

}  // namespace dwell
