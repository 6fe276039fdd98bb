// motion_study: how good the coefficients of any motion are, on random rigs. See --help.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "tests/study/any_motion.hpp"
#include "tests/study/motion_times.hpp"
#include "tests/study/pool.hpp"

namespace {

using namespace dwell::study;

double median(std::vector<double> of) {
  if (of.empty()) return NAN;
  std::nth_element(of.begin(), of.begin() + static_cast<std::ptrdiff_t>(of.size() / 2), of.end());
  return of[of.size() / 2];
}

void print(TableKind kind, const std::vector<MotionOutcome>& all, bool list) {
  double squares = 0.0, count = 0.0, inside = 0.0;
  int withheld = 0, none = 0, refused = 0, widened = 0, advised = 0, far = 0;
  std::vector<double> seconds, sizes;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const MotionOutcome& one = all[i];
    none += one.reason.empty() ? 0 : 1;
    refused += one.refused ? 1 : 0;
    widened += one.widened;
    withheld += one.withheld;
    advised += one.advised;
    seconds.push_back(one.seconds);
    double largest = 0.0;
    for (const double error : one.errors) {
      squares += error * error;
      count += 1;
      sizes.push_back(std::abs(error));
      largest = std::max(largest, std::abs(error));
    }
    far += largest > 4 ? 1 : 0;
    for (const double beyond : one.beyond) inside += beyond <= 1 ? 1 : 0;
    if (list && (!one.reason.empty() || one.widened + one.advised > 0 || largest > 3))
      std::printf("  %s %zu: %s largest error %.1f u%s%s\n", name_of(kind), i, one.reason.c_str(), largest,
                  one.widened > 0 ? ", widened" : "", one.advised > 0 ? ", advised" : "");
  }
  std::printf(
      "%-7s rigs %zu, none %d (%d refused: residuals are not noise), widened %d, withheld %d, wrong advice %d, "
      "beyond 4 u %d, coefficients %g: rms error %.3f u (robust %.3f), inside %.1f %%, median %.2f s\n",
      name_of(kind), all.size(), none, refused, widened, withheld, advised, far, count, std::sqrt(squares / count),
      median(sizes) / 0.6745, 100 * inside / count, median(seconds));
}

void print_times(const std::vector<MotionTimes>& all, bool list) {
  std::vector<double> quiet, noisy, damped, light;
  int nothing = 0, never = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const MotionTimes& one = all[i];
    if (list)
      std::printf("  %zu: harmonic %.3g s, bound %.3g s, seen %.3g s, noise %.2g %%, damping ratio %.2g %%\n", i,
                  one.harmonic_s, one.bound_s, one.seen_s, 100 * one.noise, 100 * one.damping_ratio);
    nothing += std::isnan(one.harmonic_s) ? 1 : 0;
    if (std::isnan(one.harmonic_s)) continue;
    never += std::isnan(one.bound_s) ? 1 : 0;
    if (std::isnan(one.bound_s)) continue;
    (one.noise <= 0.002 ? quiet : noisy).push_back(one.seen_s / one.bound_s);
    (one.damping_ratio >= 0.02 ? damped : light).push_back(one.seen_s / one.harmonic_s);
  }
  std::printf(
      "times: %zu rigs, %d without a harmonic verdict, %d whose bound is not at 10 %% by the end of the dwell\n",
      all.size(), nothing, never);
  std::printf("  over the bound's time, median: noise <= 0.2 %% %.2f (%zu rigs), above %.2f (%zu)\n", median(quiet),
              quiet.size(), median(noisy), noisy.size());
  std::printf("  over the harmonic verdict's time, median: damping ratio >= 2 %% %.3f (%zu rigs), below %.3f (%zu)\n",
              median(damped), damped.size(), median(light), light.size());
}

// Rigs whose drive begins with the recording, whose brackets do not ring.
void play_all_times(int rigs, int most, std::uint64_t seed, int only, bool list) {
  std::vector<Case> cases;
  if (only >= 0) rigs = 1;
  for (int i = std::max(0, only); static_cast<int>(cases.size()) < rigs; ++i) {
    Case about = draw_motion_case(TableKind::dwell, seed, i, most);
    if (about.change_s == 0 && about.remark.find("rings") == std::string::npos) cases.push_back(std::move(about));
  }
  std::vector<MotionTimes> all(cases.size());
  for_all(static_cast<int>(all.size()), "times",
          [&](int i) { all[static_cast<std::size_t>(i)] = play_times(cases[static_cast<std::size_t>(i)]); });
  print_times(all, list);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("How good the coefficients of any motion are, on random rigs, seeded.");
  int rigs = 200, most = 3, only = -1;
  double periods = 20;
  std::uint64_t seed = 1;
  bool list = false, timing = false;
  std::vector<std::string> names;
  app.add_option("names", names, "dwell, ramp, random, wander, sparse; default: all");
  app.add_option("--rigs", rigs, "of each");
  app.add_option("--masses", most, "at most");
  app.add_option("--periods", periods, "of the drive, from the start of the motion on");
  app.add_option("--seed", seed);
  app.add_option("--only", only, "this rig alone");
  app.add_flag("--list", list,
               "rigs without an estimate, with widened uncertainties, with advice or with errors above 3 u");
  app.add_flag("--times", timing, "only when U95 falls to 10 %, over the bound's time and over the harmonic verdict's");
  CLI11_PARSE(app, argc, argv);
  if (timing) {
    play_all_times(rigs, most, seed, only, list);
    return 0;
  }
  for (int k = 0; k < kTableKinds; ++k) {
    const auto kind = static_cast<TableKind>(k);
    if (!names.empty() && std::find(names.begin(), names.end(), name_of(kind)) == names.end()) continue;
    std::vector<MotionOutcome> all(static_cast<std::size_t>(only >= 0 ? 1 : rigs));
    for_all(static_cast<int>(all.size()), name_of(kind), [&](int i) {
      const Case about = draw_motion_case(kind, seed, only >= 0 ? only : i, most);
      if (only >= 0) std::printf("%s\n", about.description().c_str());
      all[static_cast<std::size_t>(i)] = play_motion(about, periods);
    });
    print(kind, all, list || only >= 0);
  }
  return 0;
}
