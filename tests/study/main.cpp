// dwell_study: how good the estimator is, on random rigs, against what it ought to reach. See --help.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "tests/study/disturbed.hpp"
#include "tests/study/figures.hpp"
#include "tests/study/pool.hpp"

namespace dwell::study {
namespace {

constexpr double kShortHours = 2, kHours = 100;

struct Options {
  std::vector<std::string> names;
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

// The short form plays no rig that rings for long or has many channels: those take most of the time.
bool is_quick(const Case& about) {
  return about.motion->time_constant_s() * about.frequency_hz < 30 && about.channels() <= 6;
}

// What has been found so far.
struct Findings {
  std::vector<Row> rows;
  std::vector<Outcome> begun;    // of every population that begins with a transient
  std::vector<Outcome> judged;   // of those by which it is judged what is reported
  std::vector<Outcome> healthy;  // of those without disturbance
  std::vector<std::string> bad;
  std::vector<std::string> tables;  // beside the rows
  long rearmed = 0;                 // although the drive was steady
};

template <typename One, typename Play>
std::vector<One> play_all(const Options& options, Population population, int count, const Play& play) {
  std::vector<int> indices;
  for (int index = 0; static_cast<int>(indices.size()) < count; ++index)
    if (!options.is_short || is_quick(draw(population, options.seed, index))) indices.push_back(index);
  std::vector<One> outcomes(static_cast<std::size_t>(count));
  for_all(count, name_of(population), [&](int i) {
    const auto at = static_cast<std::size_t>(i);
    outcomes[at] = play(draw(population, options.seed, indices[at]), Trace{});
  });
  return outcomes;
}

void append(std::vector<Outcome>& to, const std::vector<Outcome>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

template <typename One, typename Bad>
void list_bad(const Options& options, Population population, const std::vector<One>& outcomes, const Bad& is_bad,
              Findings& findings) {
  if (!options.list_bad) return;
  findings.bad.push_back(text("%s, missed:", name_of(population)));
  int listed = 0;
  for (const One& outcome : outcomes)
    if (is_bad(outcome) && listed++ < 20)
      findings.bad.push_back(text("  --only %d  ", outcome.index) +
                             draw(population, options.seed, outcome.index).description());
}

void study_begun(const Options& options, Population population, Findings& findings) {
  const auto outcomes = play_all<Outcome>(options, population, options.count(30, 5000), play_dwell);
  if (population == Population::white || population == Population::tracked) {
    const bool tracked = population == Population::tracked;
    findings.rows.push_back(bound_row(outcomes, tracked ? 1.10 : 1.05, options.slack()));
    findings.rows.back().figure = tracked ? "rms error over the Cramér-Rao bound, frequency tracked from 1 % off"
                                          : "rms error over the Cramér-Rao bound, frequency given";
    append(findings.judged, outcomes);
  }
  if (population != Population::tracked) findings.rows.push_back(coverage_row(outcomes, population, options.slack()));
  if (options.list_bad)
    for (std::string& line : worst(outcomes, population, options.seed)) findings.bad.push_back(std::move(line));
  for (const Outcome& outcome : outcomes) findings.rearmed += outcome.rearmed;
  append(findings.begun, outcomes);
  if (population != Population::hum && population != Population::coarse) {
    append(findings.healthy, outcomes);
    for (const Outcome& outcome : outcomes)
      if (options.list_bad && !outcome.blamed.empty())
        findings.bad.push_back(text("%s, healthy, --only %d: ", name_of(population), outcome.index) + outcome.blamed);
  }
}

void study(const Options& options, Population population, Findings& findings) {
  switch (population) {
    case Population::stiff: {
      const auto outcomes = play_all<Outcome>(options, population, options.count(30, 1500), play_dwell);
      list_bad(
          options, population, outcomes,
          [](const Outcome& outcome) {
            return std::any_of(outcome.elements.begin(), outcome.elements.end(),
                               [](const ElementOutcome& e) { return e.reported && e.snr_d < 1; });
          },
          findings);
      for (const Outcome& outcome : outcomes) findings.rearmed += outcome.rearmed;
      append(findings.judged, outcomes);
      break;
    }
    case Population::amplitude_step:
    case Population::frequency_step:
    case Population::small_step:
    case Population::stop: {
      const auto outcomes = play_all<StepOutcome>(options, population, options.count(30, 1000), play_step);
      findings.rows.push_back(step_row(outcomes, population, options.slack()));
      for (const StepOutcome& outcome : outcomes) findings.rearmed += outcome.disturbed;
      list_bad(
          options, population, outcomes,
          [](const StepOutcome& o) { return !o.measured || o.disturbed || o.seen_periods > o.limit_periods; },
          findings);
      break;
    }
    case Population::steady: {
      const double quarter = 0.25;  // hours of each rig
      const int count =
          options.count(static_cast<int>(kShortHours / quarter), static_cast<int>(1.05 * kHours / quarter));
      const auto outcomes = play_all<HoursOutcome>(options, population, count, play_hours);
      findings.rows.push_back(hours_row(outcomes, findings.rearmed, options.slack()));
      list_bad(
          options, population, outcomes, [](const HoursOutcome& o) { return o.rearmed > 0 || o.hours == 0; }, findings);
      break;
    }
    case Population::ramps: {
      const auto outcomes = play_all<RampsOutcome>(options, population, options.count(60, 2000), play_ramps);
      findings.rows.push_back(ramps_row(outcomes, options.slack()));
      list_bad(
          options, population, outcomes, [](const RampsOutcome& o) { return o.beyond || !o.found; }, findings);
      break;
    }
    case Population::disturbed: {
      const auto outcomes =
          play_all<DisturbedOutcome>(options, population, options.count(kKinds, 5012), play_disturbed);
      for (Row& row : disturbed_rows(outcomes, options.slack())) findings.rows.push_back(std::move(row));
      findings.tables = disturbed_table(outcomes);
      if (options.list_bad)
        for (std::string& line : disturbed_worst(outcomes, options.seed)) findings.bad.push_back(std::move(line));
      break;
    }
    default:
      study_begun(options, population, findings);
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
  Findings findings;
  for (const Population population : wanted) study(options, population, findings);
  std::vector<Row>& rows = findings.rows;
  if (!findings.begun.empty())
    for (Row& row : settling_rows(findings.begun, options.slack())) rows.push_back(std::move(row));
  if (!findings.healthy.empty()) rows.push_back(blamed_row(findings.healthy, options.slack()));
  if (!findings.judged.empty())
    for (Row& row : reported_rows(findings.judged, options.slack())) rows.push_back(std::move(row));
  if (options.is_short) std::puts("The short form: few dwells, no slow rigs, and wider bounds than the targets shown.");
  print(rows);
  if (!findings.begun.empty())
    for (const std::string& line : beside(findings.begun)) std::puts(line.c_str());
  for (const std::string& line : findings.tables) std::puts(line.c_str());
  for (const std::string& line : findings.bad) std::puts(line.c_str());
  return std::all_of(rows.begin(), rows.end(), [](const Row& row) { return row.met; }) ? 0 : 1;
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
  app.add_option("--only", options.only, "play this dwell alone and tell what happens");
  CLI11_PARSE(app, argc, argv);
  return dwell::study::run(options);
}
