// How improbable a thing must be by chance before something is decided: one rule for all of core. The more often a
// question is asked, and the more its answer costs, the more is needed.
//
// In standard deviations of a normal error:
//
//   kNoise 3   chance exceeds it once in 370     a difference below it is noise; above it, more data are awaited
//   kShown 4   once in 16 000                    the program decides about its own data, some times a dwell
//   kSure  5   once in 1.7 million               a person is told, a cause is named, a motion is found
//   kAlarm 6   once in 5·10⁸                     asked some times a second, for hours
//   kPlain 8   once in 10¹⁵                      it must be plain even where the noise is not normal
//
// Halved, kNoise calls a seventh of all healthy differences real, and kSure takes chance for a fault in one dwell of a
// hundred. Doubled, kNoise lets transients of six standard deviations pass as settled, and with kSure a wrong scale
// must be twice as wrong to be seen. Faults grow in proportion; chance falls as exp(-k²/2). So none of them is critical
// to better than a fifth. A decision with a level of its own (core/drive/step_watch.cpp: 5.6) says there why.
//
// In nats, for likelihood ratios (Wald) and for the power of two components over its variance, whose chance is exp(-x):
// the names say once in how many times. Doubled, a hundredth becomes a ten-thousandth.
#pragma once

namespace dwell {

namespace sigmas {
inline constexpr double kNoise = 3.0, kShown = 4.0, kSure = 5.0, kAlarm = 6.0, kPlain = 8.0;
}

namespace nats {
inline constexpr double kOneIn100 = 4.6, kOneIn1000 = 6.9, kOneIn10000 = 9.2, kOneIn1e6 = 13.8;
}

}  // namespace dwell
