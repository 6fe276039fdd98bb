#include <algorithm>

#include "tests/study/disturbed.hpp"

namespace dwell::study {
namespace {

constexpr std::size_t kListed = 40;

// What became of the dwells of one kind.
struct Tally {
  long played = 0, silent = 0, throughout = 0, live = 0, doubted = 0, untold = 0, warned = 0, withheld = 0, right = 0;
  long harmless = 0, reported = 0, trusted = 0, covered = 0, throughout_covered = 0;
  void add(const DisturbedOutcome& outcome) {
    ++played;
    if (outcome.silent()) {
      ++silent;
      throughout += outcome.silent_throughout();
      live += outcome.silent_live();
      doubted += outcome.doubted;
      covered += outcome.covered;
      throughout_covered += outcome.covered && outcome.silent_throughout();
    } else if (outcome.worst_silent > kWrong) {
      ++untold;
    } else if (outcome.worst > kWrong) {
      ++warned;
    } else if (!outcome.reported) {
      ++withheld;
    } else {
      ++right;
    }
    if (!outcome.harmless) return;
    ++harmless;
    reported += outcome.reported;
    trusted += outcome.trusted;
  }
};

double per_cent(long part, long whole) {
  return whole == 0 ? 0.0 : 100.0 * static_cast<double>(part) / static_cast<double>(whole);
}

}  // namespace

std::vector<Row> disturbed_rows(const std::vector<DisturbedOutcome>& outcomes, double slack) {
  Tally all;
  for (const DisturbedOutcome& outcome : outcomes) all.add(outcome);
  const long counted = all.played - all.untold;
  const double throughout = per_cent(all.throughout, counted),
               surely = per_cent(all.throughout - all.throughout_covered, counted - all.throughout_covered),
               live = per_cent(all.live, counted), silent = per_cent(all.silent, counted),
               silent_surely = per_cent(all.silent - all.covered, counted - all.covered),
               reported = per_cent(all.reported, all.harmless);
  const auto row = [&](const char* figure, double value, const char* target) {
    const bool met = *target == '\0' || value <= 0.1;  // the short form as well: its dwells are always the same
    return Row{figure, text("%.2f %%", value), target, counted, met, value, value};
  };
  return {row("disturbed: a coefficient more than 5 u off, and neither method names channel or element and cause",
              throughout, "<= 0.1 %"),
          row("  … leaving out those where u of c, r explains the poles", surely, "<= 0.1 %"),
          row("  … in a live dwell: neither it, nor what the service says beside it", live, ""),
          row("  … and the harmonic method alone does not", silent, ""),
          row("  … leaving out those where u of c, r explains the poles", silent_surely, "<= 0.1 %"),
          {"disturbed: reported where the disturbance moves no coefficient by 1 u", text("%.1f %%", reported),
           ">= 90 %", all.harmless, reported >= 90 - 40 * slack, reported, -reported}};
}

std::vector<std::string> disturbed_table(const std::vector<DisturbedOutcome>& outcomes) {
  std::vector<std::string> lines{
      "",
      "Disturbed dwells by kind. Wrong: a coefficient is shown more than 5 u off. Silent: nothing names the cause and "
      "a",
      "channel or element of it (of these, doubted: for another cause). Untold: no transient or harmonic could tell.",
      "Harmless: a plain fit moves by less than 1 u.",
      "",
      "|                       |        | wrong  |         |        |       |          |       |          | of these | "
      "of these |",
      "| kind                  | played | silent | doubted | untold | said  | withheld | right | harmless | reported | "
      "trusted  |",
      "|-----------------------|--------|--------|---------|--------|-------|----------|-------|----------|----------|-"
      "---------|"};
  const auto line = [&](const char* name, const Tally& t) {
    lines.push_back(text("| %-21s | %6ld | %6ld | %7ld | %6ld | %5ld | %8ld | %5ld | %8ld | %8ld | %8ld |", name,
                         t.played, t.silent, t.doubted, t.untold, t.warned, t.withheld, t.right, t.harmless, t.reported,
                         t.trusted));
  };
  Tally all, two;
  for (int kind = 0; kind < kKinds; ++kind) {
    Tally tally;
    for (const DisturbedOutcome& outcome : outcomes)
      if (outcome.kinds.size() == 1 && outcome.kinds[0] == static_cast<Kind>(kind)) tally.add(outcome);
    if (tally.played > 0) line(name_of(static_cast<Kind>(kind)), tally);
  }
  for (const DisturbedOutcome& outcome : outcomes) {
    all.add(outcome);
    if (outcome.kinds.size() > 1) two.add(outcome);
  }
  line("two at once", two);
  line("all", all);
  return lines;
}

std::vector<std::string> disturbed_worst(const std::vector<DisturbedOutcome>& outcomes, std::uint64_t seed) {
  std::vector<std::string> lines;
  const auto list = [&](const char* what, auto&& of) {
    std::vector<std::pair<double, int>> order;
    for (const DisturbedOutcome& outcome : outcomes)
      if (const double bad = of(outcome); bad > 0) order.emplace_back(bad, outcome.index);
    std::sort(order.rbegin(), order.rend());
    lines.push_back(text("disturbed, %s: %zu", what, order.size()));
    for (std::size_t i = 0; i < std::min(kListed, order.size()); ++i)
      lines.push_back(text("  %8.3g  --only %d  ", order[i].first, order[i].second) +
                      draw(Population::disturbed, seed, order[i].second).description());
  };
  list("wrong without a word, by u", [](const DisturbedOutcome& o) { return o.silent() ? o.worst_silent : 0.0; });
  list("harmless and not reported, by 1 - shift",
       [](const DisturbedOutcome& o) { return o.harmless && !o.reported ? 1 - o.moved : 0.0; });
  return lines;
}

}  // namespace dwell::study
