// dwell_verification_study: verdicts on random rigs, as the rig file states them and with one fault. ./dev study
// verification runs it. The recordings are those of the populations white and type_b that begin with the drive.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "core/dwell/pipeline.hpp"
#include "core/motion/verification.hpp"
#include "core/motion/verification_readings.hpp"
#include "tests/study/case.hpp"
#include "tests/study/pool.hpp"
#include "tests/study/random.hpp"
#include "tests/study/recording.hpp"

namespace dwell::study {
namespace {

constexpr double kAccuracy = 0.05;
constexpr double kGiveUp_periods = 400;

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
  while (player.now_s() < about.change_s + kGiveUp_periods * about.period_s() &&
         player.now_s() < measuring_s + about.hold_periods * about.period_s()) {
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
  told.verification = verify_transient(about.rig, dwell, readings.since(INT64_MIN), kAccuracy);
  return told;
}

using Fault = std::function<void(Draws&, Case&)>;

void wrong_mass(Draws& draws, Case& about) {
  const auto k = static_cast<std::size_t>(draws.uniform(0, 0.999) * about.chain.mass_count());
  about.rig.masses[k] *= 1 + draws.sign() * draws.log_uniform(0.05, 0.5);
}
void wrong_scale(Draws& draws, Case& about) {
  const auto c = static_cast<std::size_t>(draws.uniform(0, 0.999) * about.channels());
  about.rig.channels[c].scale *= 1 + draws.sign() * draws.log_uniform(0.02, 0.3);
}
void wrong_delay(Draws& draws, Case& about) {
  const auto c = static_cast<std::size_t>(draws.uniform(0, 0.999) * about.channels());
  about.rig.channels[c].delay_s += draws.sign() * draws.log_uniform(0.002, 0.05) * about.period_s();
}

struct Row {
  const char* name;
  Population population;
  Fault fault;
};

std::vector<Told> play_row(const Row& row, int count, std::uint64_t seed, int only) {
  std::vector<Case> cases;
  if (only >= 0) count = 1;
  for (int index = std::max(0, only); static_cast<int>(cases.size()) < count; ++index) {
    Case about = draw(row.population, seed, index);
    if (about.change_s > 0 || about.chain.mass_count() == 0) continue;  // no table jumps while it is recorded
    if (about.remark.find("rings") != std::string::npos) continue;      // not what the rig file states
    if (row.fault) {
      Draws draws(mixed(about.seed));
      row.fault(draws, about);
    }
    cases.push_back(std::move(about));
  }
  std::vector<Told> told(cases.size());
  for_all(count, row.name,
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

void print_row(const char* name, const std::vector<Told>& told, bool list) {
  int settled = 0, judged = 0, adequate = 0, inadequate = 0, consistent = 0, far = 0, far_not = 0, far_adequate = 0;
  for (const Told& one : told) {
    settled += one.settled;
    if (!one.verification.consistent) {
      if (list)
        std::printf("  none: %s: %s\n", one.of.c_str(),
                    one.verification.reasons.empty() ? "" : one.verification.reasons[0].c_str());
      continue;
    }
    ++judged;
    const Verdict verdict = one.verification.verdict;
    adequate += verdict == Verdict::adequate;
    inadequate += verdict == Verdict::not_adequate;
    consistent += *one.verification.consistent;
    if (off(one.verification) > 2 * kAccuracy) {
      ++far;
      far_not += verdict == Verdict::not_adequate;
      far_adequate += verdict == Verdict::adequate;
    }
    if (list && (verdict != Verdict::adequate || !*one.verification.consistent)) {
      std::printf("  %s, %s: %s, chi2 %.3f p %.2g\n", to_string(verdict),
                  *one.verification.consistent ? "consistent" : "not consistent", one.of.c_str(), one.verification.chi2,
                  one.verification.p);
      for (const std::string& reason : one.verification.reasons) std::printf("      %s\n", reason.c_str());
    }
  }
  std::printf(
      "%-22s %5zu played, %5d settled, %5d with evidence: %5d adequate, %5d not adequate, %5d consistent; off by "
      "more than twice the accuracy %d: %d not adequate, %d adequate\n",
      name, told.size(), settled, judged, adequate, inadequate, consistent, far, far_not, far_adequate);
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
  app.add_flag("--list", list, "every dwell of the row that is not adequate or not consistent");
  app.add_option("--only", index, "the row's rig of this index alone");
  CLI11_PARSE(app, argc, argv);
  const std::vector<Row> rows = {{"white", Population::white, {}},
                                 {"type_b", Population::type_b, {}},
                                 {"mass", Population::white, wrong_mass},
                                 {"scale", Population::white, wrong_scale},
                                 {"delay", Population::white, wrong_delay}};
  for (const Row& row : rows)
    if (only.empty() || only == row.name) print_row(row.name, play_row(row, dwells, seed, index), list);
  return 0;
}
