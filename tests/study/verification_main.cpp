// dwell_verification_study: verdicts on random rigs, as the rig file states them and with one fault that stands out by
// seven of its own standard uncertainties. ./dev study verification runs it. The recordings are those of the
// populations white and type_b that begin with the drive.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "core/dwell/pipeline.hpp"
#include "core/verify/verification.hpp"
#include "core/verify/verification_readings.hpp"
#include "tests/study/case.hpp"
#include "tests/study/fault.hpp"
#include "tests/study/pool.hpp"
#include "tests/study/random.hpp"
#include "tests/study/recording.hpp"

namespace dwell::study {
namespace {

constexpr double kAccuracy = 0.05;
constexpr double kGiveUp_periods = 400;
constexpr double kStandsOut = 7.0;  // of its own u: a fault below need not be found

struct Told {
  bool settled = false, complete = false;
  Verification verification;
  std::string of;  // for --list
};

// The recording until the dwell has its periods, identified and verified as the service does.
Told play_verified(const Case& about) {
  Told told;
  told.of = std::to_string(about.index) + " " + about.description();
  Pipeline pipeline(about.rig);
  VerificationReadings readings(about.rig.channels.size());
  Player player(about);
  double first_s = -1.0, measuring_s = INFINITY;
  double give_up_s = about.change_s + kGiveUp_periods * about.period_s();
  if (about.course) give_up_s = std::min(give_up_s, about.course->end_s());
  while (player.now_s() < give_up_s && player.now_s() < measuring_s + about.hold_periods * about.period_s()) {
    const Record record = player.next();
    if (first_s < 0) first_s = 1e-9 * static_cast<double>(record.t_ns);
    pipeline.push(record);
    readings.take(pipeline.readings());
    if (pipeline.state() != State::measuring)
      measuring_s = INFINITY;
    else if (!std::isfinite(measuring_s))
      measuring_s = player.now_s();
  }
  if ((pipeline.finish() & kCompleted) == 0) return told;
  Dwell dwell = pipeline.completed();
  for (double* time : {&dwell.start_s, &dwell.settled_s, &dwell.verdict_s, &dwell.end_s, &dwell.t_ref_s})
    *time += first_s;
  told.settled = std::isfinite(dwell.settled_s);
  for (const ElementEstimate& element : dwell.elements) told.complete = told.complete || element.identifiable;
  for (const ElementEstimate& element : dwell.elements) told.complete = told.complete && element.identifiable;
  told.verification = verify_model(about.rig, dwell, readings.since(INT64_MIN), kAccuracy);
  return told;
}

struct Row {
  const char* name;
  Population population;
  std::optional<Fault> fault;
};

bool needs_rest(Fault fault) { return fault == Fault::cubic || fault == Fault::friction; }

// Rigs whose drive begins with the recording, with the row's fault where it stands out enough. passed: how many were
// drawn whose fault does not.
std::vector<Case> draw_row(const Row& row, int count, std::uint64_t seed, int only, int& passed) {
  std::vector<Case> cases;
  if (only >= 0) count = 1;
  for (int index = std::max(0, only); static_cast<int>(cases.size()) < count; ++index) {
    Case about = draw(row.population, seed, index);
    if (about.change_s > 0 || about.chain.mass_count() == 0) continue;  // no table jumps while it is recorded
    if (about.remark.find("rings") != std::string::npos) continue;      // not what the rig file states
    if (row.fault) {
      if (needs_rest(*row.fault) && about.remark.find("from rest") == std::string::npos) continue;
      Draws draws(mixed(about.seed));
      const double stands_out = put_fault(*row.fault, draws, about);
      if (only < 0 && stands_out < kStandsOut) {
        ++passed;
        continue;
      }
      char told[40];
      std::snprintf(told, sizeof told, " fault %.0f u", stands_out);
      about.remark += told;
    }
    cases.push_back(std::move(about));
  }
  return cases;
}

std::vector<Told> play_row(const Row& row, const std::vector<Case>& cases) {
  std::vector<Told> told(cases.size());
  for_all(static_cast<int>(cases.size()), row.name,
          [&](int i) { told[static_cast<std::size_t>(i)] = play_verified(cases[static_cast<std::size_t>(i)]); });
  return told;
}

// How far the worst channel is off, the noise taken off.
double off(const Verification& v) {
  double worst = 0.0;
  for (const ChannelComparison& c : v.channels)
    worst = std::max(worst, std::sqrt(std::max(0.0, c.error * c.error - c.noise * c.noise)));
  return worst;
}

void list_one(const Told& one) {
  const Verification& v = one.verification;
  std::printf("  %s, %s: %s, chi2 %.3f p %.2g\n", to_string(v.verdict),
              !v.consistent   ? "consistency not asked"
              : *v.consistent ? "consistent"
                              : "not consistent",
              one.of.c_str(), v.chi2, v.p);
  for (const std::string& reason : v.reasons) std::printf("      %s\n", reason.c_str());
  for (const ChannelComparison& c : v.channels)
    std::printf("      channel %d: %zu readings, error %.4f noise %.4f U %.4f as is %.4f beyond %.4f\n", c.channel,
                c.samples, c.error, c.noise, c.U, c.U_as_is, c.beyond_steady);
}

void print_row(const char* name, const std::vector<Told>& told, int passed, bool list) {
  int settled = 0, scored = 0, judged = 0, adequate = 0, inadequate = 0, consistent = 0;
  int far = 0, far_not = 0, far_adequate = 0;
  for (const Told& one : told) {
    if (list) list_one(one);
    const Verdict verdict = one.verification.verdict;
    settled += one.settled;
    if (one.verification.channels.empty()) continue;
    ++scored;
    judged += one.verification.consistent.has_value();
    consistent += one.verification.consistent.value_or(false);
    adequate += verdict == Verdict::adequate;
    inadequate += verdict == Verdict::not_adequate;
    if (off(one.verification) > 2 * kAccuracy) {
      ++far;
      far_not += verdict == Verdict::not_adequate;
      far_adequate += verdict == Verdict::adequate;
    }
  }
  std::printf("%-14s %zu played", name, told.size());
  if (passed > 0) std::printf(" (and %d below 7 u)", passed);
  std::printf(
      ", %d settled, %d with evidence: %d adequate, %d not adequate; consistent %d of %d; off by more than twice the "
      "accuracy %d: %d not adequate, %d adequate\n",
      settled, scored, adequate, inadequate, consistent, judged, far, far_not, far_adequate);
}

}  // namespace
}  // namespace dwell::study

int main(int argc, char** argv) {
  using namespace dwell::study;
  int dwells = 300;
  std::uint64_t seed = 1;
  bool list = false;
  int index = -1;
  std::string only;
  CLI::App app("Verdicts on random rigs, right ones and ones with a fault");
  app.add_option("--dwells", dwells, "of each row")->check(CLI::PositiveNumber);
  app.add_option("--seed", seed, "another seed draws other rigs");
  app.add_option("--row", only, "this row alone");
  app.add_flag("--list", list, "every dwell of the row with its figures");
  app.add_option("--only", index, "the row's rig of this index alone");
  CLI11_PARSE(app, argc, argv);
  std::vector<Row> rows = {{"white", Population::white, {}}, {"type_b", Population::type_b, {}}};
  for (int f = 0; f < kFaults; ++f)
    rows.push_back({name_of(static_cast<Fault>(f)), Population::white, static_cast<Fault>(f)});
  for (const Row& row : rows) {
    if (!only.empty() && only != row.name) continue;
    int passed = 0;
    const std::vector<Case> cases = draw_row(row, dwells, seed, index, passed);
    print_row(row.name, play_row(row, cases), passed, list);
    std::fflush(stdout);
  }
  return 0;
}
