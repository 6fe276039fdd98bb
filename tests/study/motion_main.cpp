// motion_study: how good the coefficients of any motion are, on random rigs. See --help.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "tests/study/any_motion.hpp"
#include "tests/study/pool.hpp"

namespace {

using namespace dwell::study;

double median(std::vector<double> of) {
  if (of.empty()) return NAN;
  std::nth_element(of.begin(), of.begin() + static_cast<std::ptrdiff_t>(of.size() / 2), of.end());
  return of[of.size() / 2];
}

void print(TableKind kind, const std::vector<MotionOutcome>& all, bool list) {
  double squares = 0.0, count = 0.0, inside = 0.0, withheld = 0.0, none = 0.0;
  std::vector<double> seconds, ratio, sizes;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const MotionOutcome& one = all[i];
    none += one.reason.empty() ? 0 : 1;
    withheld += one.withheld;
    seconds.push_back(one.seconds);
    double largest = 0.0;
    for (const double error : one.errors) {
      squares += error * error;
      count += 1;
      sizes.push_back(std::abs(error));
      largest = std::max(largest, std::abs(error));
    }
    for (const double beyond : one.beyond) inside += beyond <= 1 ? 1 : 0;
    if (std::isfinite(one.wide_periods) && std::isfinite(one.harmonic_periods))
      ratio.push_back(one.wide_periods / one.harmonic_periods);
    if (list && (!one.reason.empty() || largest > 4))
      std::printf("  %s %zu: %s largest error %.1f u\n", name_of(kind), i, one.reason.c_str(), largest);
  }
  std::printf(
      "%-7s rigs %zu, none %g, withheld %g, coefficients %g: rms error %.3f u (robust %.3f), inside %.1f %%, median "
      "%.2f s\n",
      name_of(kind), all.size(), none, withheld, count, std::sqrt(squares / count), median(sizes) / 0.6745,
      100 * inside / count, median(seconds));
  if (!ratio.empty())
    std::printf("        U95 <= 10 %% of all after %.3f of the harmonic verdict's time (median of %zu)\n",
                median(ratio), ratio.size());
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("How good the coefficients of any motion are, on random rigs, seeded.");
  int rigs = 200, most = 3, only = -1;
  double periods = 20;
  std::uint64_t seed = 1;
  bool list = false, timing = false;
  std::vector<std::string> names;
  app.add_option("names", names, "dwell, ramp, random, wander; default: all");
  app.add_option("--rigs", rigs, "of each");
  app.add_option("--masses", most, "at most");
  app.add_option("--periods", periods, "of the drive, from the start of the motion on");
  app.add_option("--seed", seed);
  app.add_option("--only", only, "this rig alone");
  app.add_flag("--list", list, "rigs without an estimate or with errors above 4 u");
  app.add_flag("--times", timing, "when U95 falls to 10 %, against the harmonic verdict (dwell)");
  CLI11_PARSE(app, argc, argv);
  for (int k = 0; k < kTableKinds; ++k) {
    const auto kind = static_cast<TableKind>(k);
    if (!names.empty() && std::find(names.begin(), names.end(), name_of(kind)) == names.end()) continue;
    std::vector<MotionOutcome> all(static_cast<std::size_t>(only >= 0 ? 1 : rigs));
    for_all(static_cast<int>(all.size()), name_of(kind), [&](int i) {
      const Case about = draw_motion_case(kind, seed, only >= 0 ? only : i, most);
      if (only >= 0) std::printf("%s\n", about.description().c_str());
      all[static_cast<std::size_t>(i)] = play_motion(about, periods, timing && kind == TableKind::dwell);
    });
    print(kind, all, list || only >= 0);
  }
  return 0;
}
