// Is the model good enough for its use? The test is repeated virtually over a motion that the coefficients were not
// fitted to, the transient before the data that count, and held against what was measured (docs/method.md,
// Verification; ASME V&V 20-2009).
//
// Every source of error moves coefficients and prediction at once, so that correlations are kept: one virtual test per
// source, with its one standard deviation, and its difference to the nominal one is that source's column. Noise of the
// table, of the readings and of the estimated initial state are draws through the same linear operator.
#pragma once

#include <vector>

#include "core/result/dwell.hpp"
#include "core/result/verification.hpp"
#include "core/rig/rig.hpp"
#include "core/verify/verification_stretch.hpp"

namespace dwell {

// before: as transient_before(). accuracy: of each channel's rms, what the model is needed for. "not verified yet" with
// the reason where there is no evidence, or where the dwell gives no complete chain. Allocates; thread-safe;
// O(sources · readings · states²), seconds at most (kMostReadings).
[[nodiscard]] Verification verify_transient(const Rig& rig, const Dwell& dwell,
                                            const std::vector<ChannelReadings>& before, double accuracy);

}  // namespace dwell
