// Whether the numbers of an element may be given to a machine: decided here alone, for /metrics and for PLCs. A person
// reads the reasons beside a number; a machine only takes the number. So it is given none that is stale or that no
// dwell measures now.
#pragma once

#include <array>
#include <cstdint>

#include "daemon/service_view.hpp"

namespace dwell {

enum class Standing : std::uint8_t {
  valid,             // measured now, without a doubt
  doubtful,          // measured now, but a doubt names the element: its numbers must not be relied on
  not_settled,       // no dwell is measured: idle, settling, ended, or its data do not suffice
  not_identifiable,  // the channels do not deliver, or do not determine the element
  stale,             // the estimate is overdue, or the service itself does not work
};
inline constexpr std::array kStandings{Standing::valid, Standing::doubtful, Standing::not_settled,
                                       Standing::not_identifiable, Standing::stale};
[[nodiscard]] const char* to_string(Standing standing) noexcept;  // "valid", "doubtful", "not settled", …

// Whether the estimate is overdue, or the service itself does not work. Then nothing of the dwell, the channels and the
// devices is known to be true now.
[[nodiscard]] bool is_stale(const ServiceView& now) noexcept;

// How element k (1 …) stands. Pure.
[[nodiscard]] Standing standing_of(const ServiceView& now, int k) noexcept;

// The numbers of element k; null unless standing_of() is valid or doubtful.
[[nodiscard]] const ElementEstimate* element_to_hand_out(const ServiceView& now, int k) noexcept;

}  // namespace dwell
