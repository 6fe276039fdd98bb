// A verification for people: the verdict, what it rests on, the accuracy asked for and seen, a line per channel.
#pragma once

#include <string>

#include "core/result/verification.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// Lines, each with its end. Bound to one thread, not real-time: allocates.
[[nodiscard]] std::string verification_text(const Verification& verification, const Rig& rig, const Dwell& dwell);

}  // namespace dwell
