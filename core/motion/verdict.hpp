// The verdict of a comparison, after ASME V&V 20-2009: a model error lies within E ± U_val, so
//
//   adequate       error + U <= accuracy, and <= beyond / kBeyondSteady
//                  where the statistics leave something unexplained: 2 · error + U, for it may show as much again
//   not adequate   √(error² - noise²) - U > accuracy
//   else           not verified yet: the evidence is too weak
//
// error, U and noise are parts of the channel's rms. The noise of the readings compared raises `error` and says nothing
// against the model, so that the second line takes it off; the first does not, which errs on the safe side.
//
// Evidence must hold what the coefficients were not fitted to. What the phasors of the one steady frequency give for
// any motion without memory, y(t) = Re(ρ) y_0(t) + Im(ρ)/ω y_0'(t), proves nothing: every chain with these phasors
// predicts it. `beyond` is the rms of what the prediction differs from that, and an error must be small beside it too.
#pragma once

#include <string>
#include <vector>

#include "core/result/verification.hpp"

namespace dwell {

// A model that gets a quarter of what is beyond the steady motion wrong is not called adequate. With half this number
// one that is wrong by half would be; with twice it many good rigs that settle slowly stay unverified.
inline constexpr double kBeyondSteady = 4.0;

// Fills verdict and reason of a channel whose figures are known. consistent: the statistics leave nothing unexplained.
// Allocates; thread-safe.
void judge(ChannelComparison& channel, double accuracy, bool consistent);

// The verdict of the whole from those of its channels: adequate where all are, not adequate where one is. Fills
// verdict, seen, U, e_n. names: of the rig's channels, for the reasons.
void judge(Verification& verification, const std::vector<std::string>& names);

}  // namespace dwell
