// A verification for people: the verdict, what it rests on, the accuracy asked for and seen, a line per channel.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/result/verification.hpp"
#include "core/rig/rig.hpp"
#include "daemon/report/dwell_view.hpp"

namespace dwell {

// A verification with what it needs to be read; made from core's or from its JSON.
struct VerificationView {
  std::string rig;                     // its name; empty: not known
  std::vector<ChannelLabel> channels;  // by ChannelComparison::channel
  std::optional<int> dwell;            // index of the dwell; none: it has none
  Verification verification;
};
[[nodiscard]] VerificationView make_view(const Verification& verification, const Rig& rig, const Dwell& dwell);

// Lines, each with its end. Bound to one thread, not real-time: allocates.
[[nodiscard]] std::string verification_text(const VerificationView& view);

}  // namespace dwell
