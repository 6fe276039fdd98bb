// When the next sync pulse is due, by the straight line through the newest pulses of a train, and how far it may be
// off. Bound to one thread; real-time safe.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace dwell {

class NextPulse {
 public:
  static constexpr double kJitter = 0.1;  // of a period, by which intervals may differ before their own jitter is known

  // A train begins whose period is about T_s; its pulses follow.
  void begin(double T_s) noexcept;
  // The train's newest pulse.
  void take(std::int64_t t_ns, std::int64_t k) noexcept;

  // After the first pulse of a train: periods from where the line has the newest pulse to t.
  [[nodiscard]] double periods_to(std::int64_t t_ns) const noexcept;
  // Periods by which a pulse of the train may be off a whole number of these.
  [[nodiscard]] double allowed() const noexcept;
  // Period of the line, s.
  [[nodiscard]] double T_s() const noexcept { return T_s_; }
  // The newest pulse, of whichever train; INT64_MIN: none yet.
  [[nodiscard]] std::int64_t newest_ns() const noexcept { return newest_ns_; }
  [[nodiscard]] std::int64_t newest_k() const noexcept { return newest_k_; }

 private:
  static constexpr std::size_t kRecent = 16;  // pulses that foretell the next

  void fit() noexcept;

  struct Recent {
    std::int64_t t_ns, k;
  };
  std::array<Recent, kRecent> recent_{};
  std::size_t count_ = 0;  // pulses of the train so far
  double guess_s_ = 0.0;   // the period where one pulse is all there is
  std::int64_t newest_ns_ = INT64_MIN, newest_k_ = 0;
  double T_s_ = 0.0, spread_s_ = 0.0;  // of the recent ones: their line's period, and how they lie about it
  double due_s_ = 0.0;                 // where that line has pulse newest_k_, from newest_ns_
};

}  // namespace dwell
