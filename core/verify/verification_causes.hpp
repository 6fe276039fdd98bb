// Why does a model not explain the readings that it was verified on? Looks for terms that the rig file lacks, with the
// search for missing terms of any motion (core/motion/missing_terms.hpp), on the same readings. The chain is fitted to
// them anew, so the causes depend on the readings and the rig file alone, not on the verified coefficients.
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
  std::vector<std::string> unchecked;  // what these readings cannot decide
  std::string none;                    // why no cause is named; empty: one is named
};

// Whether a cause is to be looked for: the model is not consistent or not adequate, or the coefficients are doubted.
[[nodiscard]] bool asks_for_causes(const Verification& verification, const Dwell& dwell) noexcept;

// readings: per channel of the rig, SI, as stamped, as for verify_model(). Only readings up to until_ns are used. Takes
// seconds; a minute for some thousand readings at irregular instants. Allocates; thread-safe.
[[nodiscard]] Causes find_causes(const Rig& rig, const std::vector<ChannelReadings>& readings, std::int64_t until_ns);

// Adds the causes to a verification.
void tell_causes(const Causes& causes, Verification& out);

}  // namespace dwell
