// The verdict of a comparison, after ASME V&V 20-2009. Of a channel, in parts of its rms: `error` = rms of predicted
// minus measured; off = √(error² - noise²), the error without noise. It has two uncertainties: U counts all sources;
// U_as_is takes coefficients and masses as the model's own numbers, which the standard calls hard-wired.
//
//   adequate       off + U_as_is <= accuracy, and <= beyond_steady / kBeyondSteady
//                  of a model that is not consistent: 2 · error + U, for another motion may show as much again
//   not adequate   off - U > accuracy
//   else           not verified yet: the evidence is too weak
//
// A user of the model uses these coefficients, and the comparison shows the error with them. A model whose r is known
// to ± 30 % and which predicts the transient to 1 % is adequate. The second line takes the whole U: an error that the
// uncertainty of the coefficients explains does not condemn the chain.
//
// Evidence must hold what the coefficients were not fitted to. If the chain had no natural oscillations, the steady
// phasor ρ of a channel against the table would predict y(t) = Re(ρ) y_0(t) + Im(ρ)/ω y_0'(t) for any motion. Every
// chain with that phasor predicts this part, so that it tests nothing. `beyond_steady` is the rms of the prediction
// less this part; the error must be small beside it too.
#pragma once

#include <string>
#include <vector>

#include "core/result/verification.hpp"

namespace dwell {

// An adequate model predicts the part beyond the steady motion to a quarter of its size. Halved, an error of half that
// size would pass. Doubled, many good rigs that settle slowly would stay unverified.
inline constexpr double kBeyondSteady = 4.0;

// Sets verdict and reason of a channel whose figures are known. consistent: noise and the stated sources explain all
// residuals. Allocates; thread-safe.
void judge(ChannelComparison& channel, double accuracy, bool consistent);

// The verdict on the model from the verdicts on its channels: adequate if all are, not adequate if one is not. A
// channel within the accuracy whose transient is too weak to test the chain is ignored if more than half of all
// channels are adequate. Sets verdict, seen, U, e_n. names: of the rig's channels, for the reasons.
void judge(Verification& verification, const std::vector<std::string>& names);

}  // namespace dwell
