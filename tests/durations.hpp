// Durations in ns, for tests.
#pragma once

#include <cstdint>

namespace dwell {

inline constexpr std::int64_t kMs_ns = 1'000'000, kSecond_ns = 1'000'000'000, kHour_ns = 3600 * kSecond_ns;

}  // namespace dwell
