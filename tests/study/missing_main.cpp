// missing_study: whether faults of a rig are named, and whether a healthy one is left alone. See --help.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "tests/study/missing_faults.hpp"
#include "tests/study/pool.hpp"

namespace {

using namespace dwell::study;

void print(MissingFault fault, const std::vector<FaultOutcome>& all, bool list) {
  int played = 0, detected = 0, first = 0, named = 0, wrong = 0, inside = 0, valued = 0;
  double seconds = 0.0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const FaultOutcome& one = all[i];
    if (list && !one.named)
      std::printf("  %zu %s%s, %.1f u: %s\n", i, one.skipped.c_str(), one.truth.c_str(), one.size, one.told.c_str());
    if (!one.skipped.empty()) continue;
    ++played;
    detected += one.detected ? 1 : 0;
    first += one.named_first ? 1 : 0;
    named += one.named ? 1 : 0;
    wrong += one.named_some && !one.named ? 1 : 0;
    seconds += one.seconds;
    if (!std::isfinite(one.error)) continue;
    ++valued;
    inside += std::abs(one.error) < 1.96 ? 1 : 0;
  }
  std::printf(
      "%-16s rigs %d (skipped %zu): detected %d, named first %d, in the group %d, something else %d; value within "
      "U95 %d of %d; %.1f s each\n",
      name_of(fault), played, all.size() - static_cast<std::size_t>(played), detected, first, named, wrong, inside,
      valued, seconds / std::max(1, played));
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Whether faults of a rig are named, and whether a healthy one is left alone; random rigs, seeded.");
  int rigs = 40, most = 2, only = -1;
  double periods = 20;
  std::uint64_t seed = 1;
  bool list = false;
  std::vector<std::string> names;
  app.add_option("names", names,
                 "none, mass, scale, delay, ground_damping, ground_stiffness, friction, cubic, reversed, "
                 "swapped; default: all");
  app.add_option("--rigs", rigs, "of each");
  app.add_option("--masses", most, "at most");
  app.add_option("--periods", periods, "of the drive, from the start of the motion on");
  app.add_option("--seed", seed);
  app.add_option("--only", only, "this rig alone");
  app.add_flag("--list", list, "what was told where the fault is not named");
  CLI11_PARSE(app, argc, argv);
  for (int k = 0; k < kMissingFaults; ++k) {
    const auto fault = static_cast<MissingFault>(k);
    if (!names.empty() && std::find(names.begin(), names.end(), name_of(fault)) == names.end()) continue;
    std::vector<FaultOutcome> all(static_cast<std::size_t>(only >= 0 ? 1 : rigs));
    for_all(static_cast<int>(all.size()), name_of(fault), [&](int i) {
      all[static_cast<std::size_t>(i)] = play_fault(fault, seed, only >= 0 ? only : i, most, periods);
    });
    print(fault, all, list || only >= 0);
  }
  return 0;
}
