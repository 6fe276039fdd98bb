// One dwell of the study: a rig as it truly is, the rig as its file states it, and every disturbance of its recording.
// Drawn from (seed, population, index) alone.
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/model/chain.hpp"
#include "core/rig/rig.hpp"
#include "tests/study/disturbance.hpp"
#include "tests/study/motion.hpp"
#include "tests/study/random.hpp"

namespace dwell::study {

// What a dwell is drawn for. All but the last few share rigs, drives, sampling and transients.
enum class Population {
  white,      // white noise, frequency given, at least 50 periods
  tracked,    // the same, frequency refined from 1 % off
  hum,        // mains hum on every channel
  type_b,     // true scale, delay, filter corner, mass, clock and turnaround are off by what the rig file states
  quantized,  // rounded, noise of half a step or more
  coarse,     // rounded, less noise than that
  stiff,      // an element that hardly deforms
  amplitude_step,
  frequency_step,
  small_step,
  stop,
  steady,     // a long time of an unchanged drive, every disturbance of the transducers
  ramps,      // n = 0, three periods between ramps
  disturbed,  // what devices, drives and rigs do that a rig file does not know of
  resonance,  // the drive within the half-power width of a lightly damped mode
  knocks,     // knocked while it settles; what is judged begins with the last knock
};
inline constexpr int kPopulations = 16;
[[nodiscard]] const char* name_of(Population population);

// How a channel is sampled, and what is added to what it reads.
struct Line {
  double rate_hz = 0.0;
  double phase = 0.0;    // of its instants, in intervals
  double jitter = 0.0;   // of each instant, in intervals, peak to peak
  int scan = -1;         // channels of one scan are read at one instant; -1: by itself
  double shift_s = 0.0;  // its stamps are late by this
  double mean = 0.0;     // SI, as all that follows
  double sigma = 0.0;    // white noise
  double hum = 0.0, hum_hz = 50.0, hum_phase = 0.0;
  double step = 0.0;  // of rounding; 0: none
  [[nodiscard]] double noise() const { return std::sqrt(sigma * sigma + step * step / 12); }
};

// Three periods between ramps: what the table's amplitude is multiplied by. Without: 1.
struct Ramps {
  double rise_s = 0.0, hold_s = 0.0, fall_s = INFINITY, end_s = INFINITY;
  [[nodiscard]] double factor(double t_s) const {
    if (t_s >= hold_s && t_s <= fall_s) return 1.0;
    if (t_s <= rise_s || t_s >= end_s) return 0.0;
    return t_s < hold_s ? (t_s - rise_s) / (hold_s - rise_s) : (end_s - t_s) / (end_s - fall_s);
  }
};

struct Case {
  Population population = Population::white;
  int index = 0;
  std::uint64_t seed = 0;
  Chain chain;                  // as it truly is
  Rig rig;                      // as stated
  double frequency_hz = 0.0;    // true, of the drive that is judged
  std::vector<Sensor> sensors;  // per channel
  std::vector<Line> lines;      // per channel
  std::shared_ptr<Motion> motion;
  std::vector<std::uint32_t> half_ns;  // per channel, Record::t_half_ns
  double clock_error = 0.0;            // relative: stamps run fast by this
  double change_s = 0.0;               // where the drive that is judged begins
  double hold_periods = 50.0;          // to be measured after the verdict
  TableMotion table, after;            // the drive that is judged; what it becomes at a step
  double limit_periods = 0.0;          // after the step, within which it must be seen
  double hours = 0.0;                  // of a steady drive
  Ramps ramps;
  double glitches = 0.0;  // part of the force readings that are far off
  double lost = 0.0;      // part of the packets that are lost
  std::string remark;     // what is special
  std::vector<Disturbance> disturbances;
  bool without_transient = false;        // readings of the newest drive's steady motion alone
  std::vector<Mishap> mishaps;           // per channel, or none
  std::vector<SideSpring> side;          // springs that the chain does not know
  std::shared_ptr<const Course> course;  // in place of `motion`, where the chain is not linear
  [[nodiscard]] double period_s() const { return 1 / frequency_hz; }
  [[nodiscard]] int channels() const { return static_cast<int>(lines.size()); }
  [[nodiscard]] double samples_per_period(int c) const {
    return lines[static_cast<std::size_t>(c)].rate_hz / frequency_hz;
  }
  // What may be left of the transient in channel c (issue: tolerance × steady amplitude, or 3σ√(2/N(10))).
  [[nodiscard]] double threshold(int c) const;
  // One line for whoever looks into it.
  [[nodiscard]] std::string description() const;
};

[[nodiscard]] Case draw(Population population, std::uint64_t seed, int index);

}  // namespace dwell::study
