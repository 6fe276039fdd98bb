// Whether the numbers of an element may be handed to a machine: decided here alone, for /metrics and for PLCs. A person
// reads the reasons beside a number; a machine takes the number. So it is given none that is old or of another dwell.
#pragma once

#include <array>
#include <cstdint>

#include "daemon/service_view.hpp"

namespace dwell {

enum class Standing : std::uint8_t {
  valid,             // measured now, and nothing speaks against it
  doubtful,          // measured now, but a doubt names it: the numbers must not be relied on
  not_settled,       // no dwell is measured: idle, settling, ended, or its data do not suffice
  not_identifiable,  // its channels do not deliver, or cannot tell it
  stale,             // the service no longer renews what it knows
};
inline constexpr std::array kStandings{Standing::valid, Standing::doubtful, Standing::not_settled,
                                       Standing::not_identifiable, Standing::stale};
[[nodiscard]] const char* to_string(Standing standing) noexcept;  // "valid", "doubtful", "not settled", …

// Whether what is known is overdue, or the service itself does not work: then nothing of the dwell, its channels and
// its devices is known to be true now.
[[nodiscard]] bool is_stale(const ServiceView& now) noexcept;

// How element k (1 …) stands. Pure.
[[nodiscard]] Standing standing_of(const ServiceView& now, int k) noexcept;

// Its numbers; null: none may be handed out, for standing_of() is neither valid nor doubtful.
[[nodiscard]] const ElementEstimate* element_to_hand_out(const ServiceView& now, int k) noexcept;

}  // namespace dwell
