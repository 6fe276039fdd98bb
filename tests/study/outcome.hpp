// What one dwell of the study came to, as plain numbers; the rows of the table are sums over these.
#pragma once

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "tests/study/case.hpp"

namespace dwell::study {

struct ElementOutcome {
  bool reported = false;
  double snr_d = 0.0, snr_Z = 0.0;            // true |d|/σ_d, |Z|/σ_Z
  double c_error = 0.0, r_error = 0.0;        // reported minus true, over the Cramér-Rao bound
  double c_U95 = 0.0, r_U95 = 0.0;            // the same over the stated U95
  double c_relative = 0.0, r_relative = 0.0;  // the same over the true value, absolute
  double naive_c = 0.0, naive_r = 0.0;        // what the script gives, likewise
};

struct Outcome {
  int index = 0, masses = 0;
  std::string remark;      // Case::remark
  bool settled = false;    // before the study gave up
  bool rearmed = false;    // measuring was left although the drive was steady
  int taken_back = 0;      // verdicts that the pipeline took back in the same hold
  bool completed = false;  // there is a result
  bool doubted = false;    // although the rig is as its file says
  bool hum_inseparable = false, hum_warned = false;
  bool by_chance = false;  // an element is withheld since chance may have made its coefficient negative
  std::string blamed;      // what a channel, an element or the drive is blamed for; empty: nothing
  double tau_periods = 0.0, period_s = 0.0;
  double verdict_s = 0.0, oracle_s = 0.0;  // from the start of the drive that is judged
  double left = 0.0;                       // largest transient from the earliest verdict on, over its threshold
  int left_channel = -1;
  double naive_answer_s = 0.0;
  double cpu_s = 0.0;            // that playing it took; no figure, but worth knowing
  double counted_periods = 0.0;  // of data that count at the end
  double answer_s = 0.0;         // from the start of the drive to the end of the data that count
  std::vector<ElementOutcome> elements;

  [[nodiscard]] double lateness_s() const { return verdict_s - oracle_s; }
};

// A step or the stop of the drive.
struct StepOutcome {
  int index = 0;
  bool measured = false;   // before the step, for as long as was wanted
  bool disturbed = false;  // measuring was left before there was a step
  double seen_periods = INFINITY, limit_periods = 0.0;
};

// A long time of an unchanged drive.
struct HoursOutcome {
  int index = 0;
  double hours = 0.0;  // measured
  int rearmed = 0;
};

// Three periods between ramps.
struct RampsOutcome {
  int index = 0;
  bool found = false;   // a settled dwell within the hold
  bool beyond = false;  // a settled dwell with data of the ramps
};

// Told what happens, as it happens; for --only.
using Trace = std::function<void(const std::string&)>;

// Plays a case's recording to the pipeline until it has settled and measured for as long as the case wants.
[[nodiscard]] Outcome play_dwell(const Case& about, const Trace& trace = {});

// Plays the steady drive, then the step, until it is seen or long past.
[[nodiscard]] StepOutcome play_step(const Case& about, const Trace& trace = {});

[[nodiscard]] HoursOutcome play_hours(const Case& about, const Trace& trace = {});

[[nodiscard]] RampsOutcome play_ramps(const Case& about, const Trace& trace = {});

}  // namespace dwell::study
