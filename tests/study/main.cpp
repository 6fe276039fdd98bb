// dwell_study: how good the estimator is, on random rigs, against what it ought to reach. See --help.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include "tests/study/figures.hpp"
#include "tests/study/pool.hpp"
#include "tests/study/results.hpp"

namespace dwell::study {
namespace {

constexpr double kShortHours = 2, kHours = 100;

struct Options {
  std::vector<std::string> names, compared;
  std::string outcomes;
  int dwells = 0;
  std::uint64_t seed = 1;
  bool is_short = false, list_bad = false;
  int only = -1;

  // Of a population, unless said otherwise.
  [[nodiscard]] int count(int in_short, int in_long) const {
    return dwells > 0 ? dwells : is_short ? in_short : in_long;
  }
  [[nodiscard]] double slack() const { return is_short ? 1.0 : 0.0; }
};

int wrong(const std::string& what) {
  std::fprintf(stderr, "dwell_study: %s\n", what.c_str());
  return 2;
}

// The short form plays no rig that rings for long or has many channels: those take most of the time.
bool is_quick(const Case& about) {
  return about.motion->time_constant_s() * about.frequency_hz < 30 && about.channels() <= 6;
}

template <typename One, typename Play>
std::vector<One> play_all(const Options& options, Population population, int count, const Play& play) {
  std::vector<Case> quick;  // the short form draws until it has enough of them
  for (int index = 0; options.is_short && static_cast<int>(quick.size()) < count; ++index)
    if (Case about = draw(population, options.seed, index); is_quick(about)) quick.push_back(std::move(about));
  std::vector<One> outcomes(static_cast<std::size_t>(count));
  for_all(count, name_of(population), [&](int i) {
    const auto at = static_cast<std::size_t>(i);
    outcomes[at] = play(options.is_short ? quick[at] : draw(population, options.seed, i), Trace{});
  });
  return outcomes;
}

using Lines = std::vector<std::string>;

template <typename One, typename Bad>
void list_bad(const Options& options, Population population, const std::vector<One>& outcomes, const Bad& is_bad,
              Lines& bad) {
  bad.push_back(text("%s, missed:", name_of(population)));
  int listed = 0;
  for (const One& outcome : outcomes)
    if (is_bad(outcome) && listed++ < 20)
      bad.push_back(text("  --only %d  ", outcome.index) + draw(population, options.seed, outcome.index).description());
}

// The dwells that did worst, of all that were played.
Lines bad_of(const Options& options, const Results& results) {
  Lines bad;
  for (const auto& [population, outcomes] : results.begun) {
    if (population == Population::stiff) {
      list_bad(
          options, population, outcomes,
          [](const Outcome& outcome) {
            return std::any_of(outcome.elements.begin(), outcome.elements.end(),
                               [](const ElementOutcome& e) { return e.reported && e.snr_d < 1; });
          },
          bad);
      continue;
    }
    for (std::string& line : worst(outcomes, population, options.seed)) bad.push_back(std::move(line));
    for (const Outcome& outcome : outcomes)
      if (!outcome.blamed.empty())
        bad.push_back(text("%s, --only %d blames: ", name_of(population), outcome.index) + outcome.blamed);
  }
  for (const auto& [population, outcomes] : results.steps)
    list_bad(
        options, population, outcomes,
        [](const StepOutcome& o) { return !o.measured || o.disturbed || o.seen_periods > o.limit_periods; }, bad);
  if (!results.hours.empty())
    list_bad(
        options, Population::steady, results.hours, [](const HoursOutcome& o) { return o.rearmed > 0 || o.hours == 0; },
        bad);
  if (!results.ramps.empty())
    list_bad(
        options, Population::ramps, results.ramps, [](const RampsOutcome& o) { return o.beyond || !o.found; }, bad);
  if (!results.disturbed.empty())
    for (std::string& line : disturbed_worst(results.disturbed, options.seed)) bad.push_back(std::move(line));
  return bad;
}

void study(const Options& options, Population population, Results& results) {
  switch (population) {
    case Population::stiff:
      results.begun[population] = play_all<Outcome>(options, population, options.count(30, 1500), play_dwell);
      break;
    case Population::amplitude_step:
    case Population::frequency_step:
    case Population::small_step:
    case Population::stop:
      results.steps[population] = play_all<StepOutcome>(options, population, options.count(30, 1000), play_step);
      break;
    case Population::steady: {
      const double quarter = 0.25;  // hours of each rig
      const int count =
          options.count(static_cast<int>(kShortHours / quarter), static_cast<int>(1.05 * kHours / quarter));
      results.hours = play_all<HoursOutcome>(options, population, count, play_hours);
      break;
    }
    case Population::ramps:
      results.ramps = play_all<RampsOutcome>(options, population, options.count(60, 2000), play_ramps);
      break;
    case Population::disturbed:
      results.disturbed =
          play_all<DisturbedOutcome>(options, population, options.count(2 * kKinds, 179 * kKinds), play_disturbed);
      break;
    case Population::resonance:
    case Population::knocks:
      results.begun[population] = play_all<Outcome>(options, population, options.count(10, 2000), play_dwell);
      break;
    default:
      results.begun[population] = play_all<Outcome>(options, population, options.count(30, 5000), play_dwell);
  }
}

// Plays one dwell and tells what happens.
void play_only(const Options& options, Population population) {
  const Case about = draw(population, options.seed, options.only);
  const Trace trace = [](const std::string& line) { std::puts(line.c_str()); };
  trace(about.description());
  if (population == Population::steady)
    (void)play_hours(about, trace);
  else if (population == Population::ramps)
    (void)play_ramps(about, trace);
  else if (population == Population::disturbed)
    (void)play_disturbed(about, trace);
  else if (population >= Population::amplitude_step && population <= Population::stop)
    (void)play_step(about, trace);
  else
    (void)play_dwell(about, trace);
}

int run(const Options& options) {
  std::vector<Population> wanted;
  for (int p = 0; p < kPopulations; ++p)
    if (options.names.empty() ||
        std::count(options.names.begin(), options.names.end(), name_of(static_cast<Population>(p))) > 0)
      wanted.push_back(static_cast<Population>(p));
  if (options.only >= 0) {
    play_only(options, wanted.front());
    return 0;
  }
  Results results;
  results.seed = options.seed;
  for (const Population population : wanted) study(options, population, results);
  if (!options.outcomes.empty()) {
    std::ofstream file(options.outcomes);
    write(file, results);
    if (!file.flush()) return wrong("cannot write " + options.outcomes);
  }
  const std::vector<Row> rows = rows_of(results, options.slack());
  if (options.is_short) std::puts("The short form: few dwells, no slow rigs, and wider bounds than the targets shown.");
  print(rows);
  Lines lines;
  if (const std::vector<Outcome> begun = results.all_begun(); !begun.empty()) lines = beside(begun);
  if (!results.disturbed.empty())
    for (std::string& line : disturbed_table(results.disturbed)) lines.push_back(std::move(line));
  if (options.list_bad)
    for (std::string& line : bad_of(options, results)) lines.push_back(std::move(line));
  for (const std::string& line : lines) std::puts(line.c_str());
  return std::all_of(rows.begin(), rows.end(), [](const Row& row) { return row.met; }) ? 0 : 1;
}

// Two files of outcomes, row by row.
int run_compare(const Options& options) {
  Results results[2];
  for (std::size_t i = 0; i < 2; ++i) {
    std::ifstream file(options.compared[i]);
    if (!file) return wrong("cannot read " + options.compared[i]);
    if (const std::string fault = read(file, results[i]); !fault.empty())
      return wrong(options.compared[i] + ", " + fault);
  }
  Lines lines;
  bool worse = false;
  if (const std::string fault = compare(results[0], results[1], lines, worse); !fault.empty()) return wrong(fault);
  for (const std::string& line : lines) std::puts(line.c_str());
  return worse ? 1 : 0;
}

}  // namespace
}  // namespace dwell::study

int main(int argc, char** argv) {
  dwell::study::Options options;
  CLI::App app("How good the estimator is on random rigs, as a table: what was reached, what is to be reached");
  std::vector<std::string> names;
  for (int p = 0; p < dwell::study::kPopulations; ++p)
    names.emplace_back(dwell::study::name_of(static_cast<dwell::study::Population>(p)));
  app.add_option("population", options.names, "what is studied; all where none is named")->check(CLI::IsMember(names));
  app.add_option("--dwells", options.dwells, "of each population")->check(CLI::PositiveNumber);
  app.add_option("--seed", options.seed, "another seed draws other rigs");
  app.add_flag("--short", options.is_short, "few dwells, generous bounds");
  app.add_flag("--list-bad", options.list_bad, "name the dwells that did worst by each figure");
  app.add_option("--outcomes", options.outcomes, "write one line per dwell to this file");
  app.add_option("--compare", options.compared, "BEFORE AFTER, two such files of the same seed: is any figure worse?")
      ->expected(2);
  app.add_option("--only", options.only, "play this dwell alone and tell what happens");
  CLI11_PARSE(app, argc, argv);
  if (!options.compared.empty()) return dwell::study::run_compare(options);
  return dwell::study::run(options);
}
