// What the lamps show. `ready` is steady while a dwell is settled and its coefficients are valid, and blinks otherwise:
// whoever sees it neither steady nor blinking sees a service that is dead or hangs. `fault` is lit while something is
// wrong. Pure.
#pragma once

#include <cstdint>

namespace dwell::gpio {

// What the service asks for. It must be said anew at least every kFresh_ns: a hanging service blinks nothing.
struct LampOrder {
  bool ready = false;
  bool fault = false;
};

struct LampLevels {
  bool ready = false;
  bool fault = false;
};

inline constexpr std::int64_t kBlink_ns = 500'000'000;    // as long on as off
inline constexpr std::int64_t kFresh_ns = 3'000'000'000;  // an older order is none

[[nodiscard]] constexpr LampLevels lamp_levels(const LampOrder& order, std::int64_t age_ns,
                                               std::int64_t now_ns) noexcept {
  if (age_ns > kFresh_ns) return {false, true};
  return {order.ready || (now_ns / kBlink_ns) % 2 == 0, order.fault};
}

}  // namespace dwell::gpio
