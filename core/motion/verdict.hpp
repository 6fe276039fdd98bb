// The verdict of a comparison, after ASME V&V 20-2009: a model error lies within E ± U_val, so
//
//   adequate       error + U <= accuracy, and <= beyond / kBeyondSteady
//                  where the statistics leave something unexplained: 2 · error + U, for it may show as much again
//   not adequate   √(error² - noise²) - U > accuracy
//   else           not verified yet: the evidence is too weak
//
// error, U and noise are parts of the channel's rms. The noise of the compared readings raises `error`, but it is no
// fault of the model. The second line therefore takes it off. The first line leaves it in, which errs on the safe side.
//
// Evidence must hold what the coefficients were not fitted to. A channel with the steady phasor ρ against the table
// would follow a motion without memory as y(t) = Re(ρ) y_0(t) + Im(ρ)/ω y_0'(t). Every chain with that phasor predicts
// this part, so that it proves nothing. `beyond` is the rms of the prediction less this part; the error must be small
// beside it too.
#pragma once

#include <string>
#include <vector>

#include "core/result/verification.hpp"

namespace dwell {

// An adequate model predicts the part beyond the steady motion to a quarter of its size. With half this number an error
// of half that size would pass. With twice it many good rigs that settle slowly would stay unverified.
inline constexpr double kBeyondSteady = 4.0;

// Fills verdict and reason of a channel whose figures are known. consistent: the statistics leave nothing unexplained.
// Allocates; thread-safe.
void judge(ChannelComparison& channel, double accuracy, bool consistent);

// The verdict of the whole from those of its channels: adequate where all are, not adequate where one is. Fills
// verdict, seen, U, e_n. names: of the rig's channels, for the reasons.
void judge(Verification& verification, const std::vector<std::string>& names);

}  // namespace dwell
