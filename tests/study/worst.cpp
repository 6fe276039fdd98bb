// For whoever works on the estimator: where it does badly, dwell by dwell and by kind of rig.
#include <algorithm>
#include <cmath>

#include "tests/study/figures.hpp"

namespace dwell::study {
namespace {

constexpr std::size_t kListed = 6;  // dwells of each measure

struct Measure {
  const char* name;
  double bad;  // from here on it is worth a line
  std::function<double(const Outcome&)> of;
};

double over_elements(const Outcome& outcome, const std::function<double(const ElementOutcome&)>& of) {
  double most = 0.0;
  for (const ElementOutcome& element : outcome.elements) most = std::max(most, of(element));
  return most;
}

const std::vector<Measure>& measures() {
  static const std::vector<Measure> all = {
      {"transient left at the verdict over threshold", 0.8, [](const Outcome& o) { return o.settled ? o.left : 0.0; }},
      {"lateness over max(10 periods, tau)", 0.9, [](const Outcome& o) { return late_by(o, 10, 1); }},
      {"error over Cramér-Rao bound", 2.5,
       [](const Outcome& o) {
         return over_elements(o, [&](const ElementOutcome& e) {
           return counts_for_bound(o, e) ? std::max(std::abs(e.c_error), std::abs(e.r_error)) : 0.0;
         });
       }},
      {"error over U95", 1.2,
       [](const Outcome& o) {
         return over_elements(o,
                              [](const ElementOutcome& e) { return std::max(std::abs(e.c_U95), std::abs(e.r_U95)); });
       }},
      {"elements reported although |d| is below its standard deviation", 0.5,
       [](const Outcome& o) {
         return over_elements(o, [](const ElementOutcome& e) { return e.reported && e.snr_d < 1 ? 1.0 : 0.0; });
       }},
      {"doubt of a healthy rig", 0.5, [](const Outcome& o) { return o.doubted ? 1.0 : 0.0; }},
      {"left measuring in a steady drive", 0.5, [](const Outcome& o) { return o.rearmed ? 1.0 : 0.0; }},
      {"processor seconds", 1.0, [](const Outcome& o) { return o.cpu_s; }}};
  return all;
}

// The same figures for the dwells of which `is` holds.
std::string line_of(const std::string& name, const std::vector<Outcome>& outcomes,
                    const std::function<bool(const Outcome&)>& is) {
  long count = 0, early = 0, never = 0, inside_c = 0, inside_r = 0, reported = 0, bounded = 0;
  double squares = 0.0;
  for (const Outcome& outcome : outcomes) {
    if (!is(outcome)) continue;
    ++count;
    never += !outcome.settled;
    early += outcome.settled && outcome.left > 1;
    for (const ElementOutcome& element : outcome.elements) {
      if (counts_for_bound(outcome, element)) {
        squares += element.c_error * element.c_error + element.r_error * element.r_error;
        bounded += 2;
      }
      if (!element.reported || outcome.hum_inseparable) continue;
      ++reported;
      inside_c += std::abs(element.c_U95) <= 1;
      inside_r += std::abs(element.r_U95) <= 1;
    }
  }
  const auto per_cent = [](long part, long whole) {
    return 100.0 * static_cast<double>(part) / static_cast<double>(whole);
  };
  return text("  %-22s %5ld dwells, early %5.2f %%, never %5.2f %%, error/bound %.3f, U95 holds c %.1f %% r %.1f %%",
              name.c_str(), count, per_cent(early, count), per_cent(never, count),
              std::sqrt(squares / static_cast<double>(bounded)), per_cent(inside_c, reported),
              per_cent(inside_r, reported));
}

}  // namespace

std::vector<std::string> worst(const std::vector<Outcome>& outcomes, Population population, std::uint64_t seed) {
  std::vector<std::string> lines;
  const std::string about = name_of(population);
  lines.push_back(about + ", by kind:");
  for (const char* kind : {"", "beating", "slow", "node", "from rest", "from any state", "after a change", "rings"}) {
    const std::string sought = kind;
    lines.push_back(line_of(sought.empty() ? "all" : sought, outcomes,
                            [&](const Outcome& outcome) { return outcome.remark.find(sought) != std::string::npos; }));
  }
  for (int n = 1; n <= 6; ++n)
    lines.push_back(line_of("n = " + std::to_string(n), outcomes, [n](const Outcome& o) { return o.masses == n; }));
  for (const Measure& measure : measures()) {
    std::vector<std::pair<double, int>> order;
    for (const Outcome& outcome : outcomes)
      if (const double bad = measure.of(outcome); bad > measure.bad) order.emplace_back(bad, outcome.index);
    if (order.empty()) continue;
    std::sort(order.rbegin(), order.rend());
    lines.push_back(about + ", worst by " + measure.name + ":");
    for (std::size_t i = 0; i < std::min(kListed, order.size()); ++i)
      lines.push_back(text("  %6.3g  --only %d  ", order[i].first, order[i].second) +
                      draw(population, seed, order[i].second).description());
  }
  return lines;
}

}  // namespace dwell::study
