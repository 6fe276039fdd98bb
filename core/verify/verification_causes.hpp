// Why does a model not explain the readings that it was verified on? The search of any motion for what is missing
// (core/motion/missing_terms.hpp), on the same readings. The chain is fitted to them anew, so the causes depend on the
// readings and the rig file alone, not on the coefficients that were verified.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/result/dwell.hpp"
#include "core/result/verification.hpp"
#include "core/rig/rig.hpp"
#include "core/verify/verification_stretch.hpp"

namespace dwell {

struct Causes {
  std::vector<MissingTerm> missing;    // likeliest first; empty: none is named
  std::vector<std::string> unchecked;  // what these readings cannot tell
  std::string none;                    // why none is named; empty: one is
};

// Whether a cause is to be looked for: the model is not consistent or not adequate, or the coefficients are doubted.
[[nodiscard]] bool asks_for_causes(const Verification& verification, const Dwell& dwell) noexcept;

// readings: per channel of the rig, SI, as stamped, as for verify_model(); of them those up to until_ns. Takes
// seconds, up to a minute of some thousand irregular readings. Allocates; thread-safe.
[[nodiscard]] Causes find_causes(const Rig& rig, const std::vector<ChannelReadings>& readings, std::int64_t until_ns);

// Writes them into a verification.
void tell_causes(const Causes& causes, Verification& out);

}  // namespace dwell
