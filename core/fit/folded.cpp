#include "core/fit/folded.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/angle.hpp"
#include "core/base/wording.hpp"
#include "core/rig/transducer.hpp"

namespace dwell {
namespace {

// Assumed limit of harmonic m: 0.3/m of the fundamental, a third of a square wave's (3 % for the ninth). Halved: 3 % of
// the ninth lie beyond 3 u. Doubled: every dwell sampled at 10 f has twice the ±.
constexpr double kLargest = 0.3;

// Highest order considered: gears, poles and slots of a motor make such orders. Above it the table's inertia leaves
// little: 1/20 of its acceleration is 1e-4 of its displacement at order 20. Doubled: every recording sampled at up to
// 40 f becomes uncertain by harmonics that hardly any drive has.
constexpr int kHighest = 20;

// Turns of the alias against the fundamental within the dwell from which on the alias is ignored. At kResolved it
// averages out: the first null of the dwell's transform. Beyond it the scatter over the dwell covers the rest
// (core/fit/scatter.hpp). Halved: an alias that makes half a turn would be ignored, although two thirds of it remain in
// the phasor. Doubled: little changes, since the second lobe of the transform is 0.2 high.
constexpr double kResolved = 1.0;
// Below so many turns the data do not show the alias, and the dwell warns. At 0.1 it would warn of one healthy dwell in
// 400, at sampling rates up to 20 f.
constexpr double kExactly = 0.02;

// An alias is ignored if irregular instants leave less than this part of its amplitude.
constexpr double kSpread = 0.05;

}  // namespace

Folded folded_onto_fundamental(const Rig& rig, const Channel& channel, const SamplingRegularity& sampling, double f,
                               double seconds) noexcept {
  Folded worst;
  for (int m = rig.excitation.harmonics + 1; m <= kHighest; ++m) {
    const SamplingRegularity::Alias alias = sampling.alias(m * f, f);
    const double turns = alias.apart_hz * seconds;
    if (!(turns < kResolved) || alias.kept < kSpread) continue;
    const double averaged = turns > 0 ? std::sin(kTwoPi / 2 * turns) / (kTwoPi / 2 * turns) : 1.0;
    const double delay_s = device_delay_s(rig, channel);
    const double passed = std::min(1.0, std::abs(response(channel, delay_s, m * f) / response(channel, delay_s, f)));
    const double part = kLargest / m * averaged * alias.kept * passed;
    if (part > worst.part) worst = {m, part, turns < kExactly};
  }
  return worst;
}

void warn_of_folded(const Rig& rig, const std::vector<Folded>& folded, Dwell& dwell) {
  for (int m = 1; m <= kHighest; ++m) {
    std::vector<std::string> names;
    double part = 0.0;
    for (std::size_t c = 0; c < folded.size(); ++c)
      if (folded[c].order == m && folded[c].exactly) {
        names.push_back(rig.channels[c].name);
        part = std::max(part, folded[c].part);
      }
    if (names.empty()) continue;
    dwell.warnings.push_back({WarningKind::folded_harmonic,
                              "harmonic " + std::to_string(m) +
                                  " of the drive, if there is any, folds onto the fundamental in " + listed(names) +
                                  ": the sampling rate is a whole multiple of the drive's frequency. ± allows for " +
                                  brief(100 * part, 2) + " % of the amplitude; change the sampling rate by 1 %",
                              {},
                              names});
  }
}

}  // namespace dwell
