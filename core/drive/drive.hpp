// Is the drive steady? Watches the table's motion alone, which is imposed and has no transient of its own.
#pragma once

#include <array>
#include <complex>

namespace dwell {

class DriveMonitor {
 public:
  // tolerance: relative change of amplitude or frequency that ends a dwell (beyond noise).
  explicit DriveMonitor(double tolerance) noexcept : tolerance_(tolerance) {}

  // A new hold begins: its first windows are its reference …
  void restart() noexcept;
  // … until the dwell's own fit is: amplitude (m, rad) and omega (rad/s).
  void refer(double amplitude, double omega) noexcept;
  // Of the reference so far, m (rad); 0 before the first window.
  [[nodiscard]] double amplitude() const noexcept { return amplitude_; }

  // One window a quarter of a period after the last: its centre, the table's phasor at that centre (m, rad), the
  // standard deviation of its components, and the omega (rad/s) it was fitted with. True: the drive is another than at
  // the reference, in two windows one after the other (a lone disturbed window is none). Real-time safe.
  bool update(double centre_s, std::complex<double> Y, double u, double omega) noexcept;

  // Angular frequency of the hold so far, from the phase's advance; NaN before a period has gone by.
  [[nodiscard]] double omega() const noexcept;
  // How many windows ago the drive was last beyond doubt as in the hold; what came after it does not count when the
  // dwell is ended by a change.
  [[nodiscard]] int windows_since_good() const noexcept { return since_good_; }

 private:
  static constexpr int kLag = 4;          // windows in a period
  static constexpr long kReference = 64;  // windows of a hold that make its reference
  static constexpr double kSure = 4.0;    // standard deviations
  struct Window {
    double centre_s;
    std::complex<double> Y;
    double u;
  };
  double tolerance_;
  std::array<Window, kLag> last_{};
  long seen_ = 0;         // windows since restart
  long frequencies_ = 0;  // windows that gave a frequency
  double amplitude_ = 0.0, omega_ = 0.0;
  int suspicious_ = 0, since_good_ = 0;
};

}  // namespace dwell
