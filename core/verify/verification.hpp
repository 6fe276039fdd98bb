// Is the model good enough for its use? The test is repeated virtually over motions that the coefficients were not
// fitted to, the transient before the data that count and other dwells, and held against what was measured
// (docs/method.md, Verification; ASME V&V 20-2009).
//
// Every source of error moves coefficients and prediction at once, so that correlations are kept: one virtual test per
// source, with its one standard deviation, and its difference to the nominal one is that source's column. Noise of the
// table, of the readings and of the estimated initial state are draws through the same linear operator.
#pragma once

#include <cstddef>
#include <vector>

#include "core/result/dwell.hpp"
#include "core/result/verification.hpp"
#include "core/rig/rig.hpp"
#include "core/verify/verification_stretch.hpp"

namespace dwell {

// Dwells beside its own that a model is held against at most: each costs as much time and memory as the first.
inline constexpr std::size_t kMostOthers = 3;

// Another settled dwell of the same rig. Its readings are evidence too, the steady ones as well where its frequency is
// another one: the coefficients are not fitted to them.
struct OtherDwell {
  Dwell dwell;
  std::vector<ChannelReadings> readings;  // from the end of the dwell before it to its own end
};

// before: as transient_before(). others: of the same recording; the kMostOthers farthest in frequency are used.
// accuracy: of each channel's rms, what the
// model is needed for. "not verified yet" with the reason where there is no evidence, or where the dwell gives no
// complete chain. Allocates; thread-safe; O(sources · readings · states²), seconds at most (kMostReadings).
[[nodiscard]] Verification verify_model(const Rig& rig, const Dwell& dwell, const std::vector<ChannelReadings>& before,
                                        double accuracy, const std::vector<OtherDwell>& others = {});

}  // namespace dwell
