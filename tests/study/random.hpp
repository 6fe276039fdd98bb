// Random numbers of the study. Draws are a sequence that belongs to one dwell; noise is a function of (seed, channel,
// sample), so that any stretch of a recording can be had again, in any order and by any thread.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

namespace dwell::study {

// splitmix64's finalizer: every bit of the result depends on every bit of x.
[[nodiscard]] inline std::uint64_t mixed(std::uint64_t x) noexcept {
  x += 0x9e3779b97f4a7c15ULL;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

// Of 64 random bits a number in (0, 1).
[[nodiscard]] inline double unit(std::uint64_t bits) noexcept {
  return (static_cast<double>(bits >> 11) + 0.5) * 0x1p-53;
}

// Of two independent numbers in (0, 1) one of the normal distribution (Box and Muller).
[[nodiscard]] inline double normal_of(double u, double v) noexcept {
  return std::sqrt(-2 * std::log(u)) * std::cos(2 * std::numbers::pi * v);
}

class Draws {
 public:
  explicit Draws(std::uint64_t seed) noexcept : state_(mixed(seed)) {}

  double uniform(double low, double high) noexcept { return low + (high - low) * unit(next()); }
  double log_uniform(double low, double high) noexcept { return low * std::exp(unit(next()) * std::log(high / low)); }
  double normal() noexcept {
    const double u = unit(next());
    return normal_of(u, unit(next()));
  }
  bool chance(double probability) noexcept { return unit(next()) < probability; }
  double sign() noexcept { return chance(0.5) ? 1.0 : -1.0; }
  // low … high, both included.
  int integer(int low, int high) noexcept {
    return low + static_cast<int>(next() % static_cast<std::uint64_t>(high - low + 1));
  }
  std::uint64_t next() noexcept { return mixed(state_++); }

 private:
  std::uint64_t state_;
};

}  // namespace dwell::study
