// Which instants a file may hold. Any file may hold any 64 bits; within these bounds every sum and difference that is
// made of an instant fits 64 bits: instant - instant, UTC - UTC, UTC + (instant - instant). So they are checked once,
// where they are read. docs/run-file.md.
#pragma once

#include <cstdint>
#include <string>

namespace dwell::record {

// Of a run's clock, before and after its zero: 73 years. CLOCK_MONOTONIC_RAW begins when the computer does.
inline constexpr std::int64_t kMostClock_ns = (std::int64_t{1} << 61U) - 1;
// Of UTC, before and after 1970: from November 1823 to February 2116.
inline constexpr std::int64_t kMostUtc_ns = (std::int64_t{1} << 62U) - 1;

[[nodiscard]] constexpr bool is_on_clock(std::int64_t t_ns) noexcept {
  return t_ns >= -kMostClock_ns && t_ns <= kMostClock_ns;
}
// What is wrong with one that is not.
[[nodiscard]] inline std::string clock_fault(std::int64_t t_ns) {
  return "its instant is " + std::to_string(t_ns) + " ns; expected less than 2^61 ns (73 years) from the clock's zero";
}

}  // namespace dwell::record
