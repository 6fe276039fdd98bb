#include "core/motion/leftover.hpp"

#include <algorithm>
#include <cmath>

#include "core/motion/given_table.hpp"
#include "core/motion/whiteness.hpp"
#include "core/rig/transducer.hpp"

namespace dwell {
namespace {

// A term that leaves more than this share unexplained is a part of the story at best.
constexpr double kMostUnexplained = 0.5;
// Fitted over directly seen noise variance of the table that is still accepted: a ratio of 1.5 in standard deviation,
// since the noise from reading to reading is known to 10 %.
constexpr double kAsSeen = 2.25;

}  // namespace

bool Leftover::explains_most_of(const Leftover& before) const {
  return power <= kMostUnexplained * before.power || (least_p >= kContradicted && of_table <= before.power);
}

Leftover leftover(const MotionModel& model, const MotionData& data, const MotionUnknowns& unknowns,
                  const std::vector<double>& noise, const std::vector<double>& size) {
  const auto given_table = innovations_given_table(model, data, unknowns);
  std::vector<double> readings(noise.size(), 0.0);
  for (const MotionReading& reading : data.readings) readings[static_cast<std::size_t>(reading.channel)] += 1.0;
  Leftover out;
  for (std::size_t a = 0; a < model.parameters().size(); ++a) {
    const Parameter& p = model.parameters()[a];
    if (p.what != Unknown::noise) continue;
    const auto c = static_cast<std::size_t>(p.index);
    const double least = std::max({std::isfinite(noise[c]) ? noise[c] : 0.0, kDigits * size[c], 1e-300});
    const double times = std::exp(2 * unknowns.theta(static_cast<Eigen::Index>(a))) / (least * least);
    if (shows_drive(model.rig().channels[c])) {
      out.of_table += readings[c] * std::max(0.0, times - kAsSeen);
      continue;
    }
    const Whiteness whiteness = whiteness_of(given_table[c]);
    if (!(whiteness.ljung_box >= 0.0)) continue;
    out.power += std::max(0.0, whiteness.ljung_box - kWhitenessLags) * times;
    out.least_p = std::min(out.least_p, whiteness.p);
  }
  out.power += out.of_table;
  return out;
}

}  // namespace dwell
