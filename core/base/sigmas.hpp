// How far a number must stand out from its noise before something is decided: one rule, in standard deviations of a
// normal error. The more often a question is asked, and the more its answer costs, the more is needed.
//
//   kNoise  chance exceeds it once in 370        a difference below it is noise; above it, more data are awaited
//   kShown  once in 16 000                       the program decides about its own data, some times a dwell
//   kSure   once in 1.7 million                  a person is told, a cause is named, a motion is found
//   kAlarm  once in 5·10⁸                        asked some times a second, for hours
//
// Halved, kNoise calls a third of all healthy differences real, and kSure takes chance for a fault in one dwell of a
// hundred. Doubled, kNoise lets transients of six standard deviations pass as settled, and with kSure a wrong scale must
// be twice as wrong to be seen. Faults grow in proportion; chance falls as exp(-k²/2). So none of them is critical to
// better than a fifth. A decision with a level of its own (core/drive/step_watch.cpp: 5.6) says there why.
#pragma once

namespace dwell::sigmas {

inline constexpr double kNoise = 3.0, kShown = 4.0, kSure = 5.0, kAlarm = 6.0;

}  // namespace dwell::sigmas
