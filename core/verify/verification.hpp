// Is the model good enough for its use? The test is repeated virtually and compared with the measured readings. Only
// motions are used that the coefficients were not fitted to: the transient before the data that count, and other dwells
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

// Most other dwells that a model is compared with. Each costs as much time and memory as the first.
inline constexpr std::size_t kMostOthers = 3;

// Another settled dwell of the same rig. The coefficients were not fitted to its readings, so they are evidence. Its
// steady motion is evidence only if its frequency differs.
struct OtherDwell {
  Dwell dwell;
  std::vector<ChannelReadings> readings;  // from the end of the dwell before it to its own end
};

// before: as for transient_before(). others: of the same recording; the kMostOthers farthest in frequency are used.
// accuracy: the accuracy that the model is needed for, as a part of each channel's rms. Without evidence or without a
// complete chain the verdict is "not verified yet", with the reason. Allocates; thread-safe; O(sources · readings ·
// states²), seconds at most (kMostReadings).
[[nodiscard]] Verification verify_model(const Rig& rig, const Dwell& dwell, const std::vector<ChannelReadings>& before,
                                        double accuracy, const std::vector<OtherDwell>& others = {});

}  // namespace dwell
