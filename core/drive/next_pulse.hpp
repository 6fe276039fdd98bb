// Predicts when the next sync pulse is due, and how far off it may be, from the straight line through the newest pulses
// of a train. Bound to one thread; real-time safe.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace dwell {

class NextPulse {
 public:
  static constexpr double kJitter = 0.1;  // part of a period that is allowed until the train's own jitter is known

  // Begins a train with a period of about T_s; take() its pulses next.
  void begin(double T_s) noexcept;
  // Takes the train's newest pulse, number k.
  void take(std::int64_t t_ns, std::int64_t k) noexcept;

  // Periods from the newest pulse, as the line places it, to t. The train must have a pulse.
  [[nodiscard]] double periods_to(std::int64_t t_ns) const noexcept;
  // How far periods_to() of a pulse of the train may be off a whole number.
  [[nodiscard]] double allowed() const noexcept;
  // Period of the line, s.
  [[nodiscard]] double T_s() const noexcept { return T_s_; }
  // The newest pulse of any train; INT64_MIN: none yet.
  [[nodiscard]] std::int64_t newest_ns() const noexcept { return newest_ns_; }
  [[nodiscard]] std::int64_t newest_k() const noexcept { return newest_k_; }

 private:
  static constexpr std::size_t kRecent = 16;  // pulses in the line

  void fit() noexcept;

  struct Recent {
    std::int64_t t_ns, k;
  };
  std::array<Recent, kRecent> recent_{};
  std::size_t count_ = 0;  // pulses of the train so far
  double guess_s_ = 0.0;   // the period while the train has one pulse
  std::int64_t newest_ns_ = INT64_MIN, newest_k_ = 0;
  double T_s_ = 0.0, spread_s_ = 0.0;  // the line's period; standard deviation of its residuals
  double due_s_ = 0.0;                 // instant of pulse newest_k_ on the line, from newest_ns_
};

}  // namespace dwell
