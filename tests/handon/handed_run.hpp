// A run file as the service leaves it, of a small rig whose coefficients are known: what the exports are tested on.
#pragma once

#include <string>
#include <vector>

#include "core/result/dwell.hpp"
#include "core/stream/record.hpp"
#include "daemon/handon/selection.hpp"
#include "tests/record/scratch.hpp"

namespace dwell::test {

// Element 1 ties the table to the ground: 240 kN/m and 310 N·s/m, driven at 4 Hz.
inline constexpr double kStiffness = 240000.0, kDamping = 310.0, kDrive_hz = 4.0;
inline constexpr double kAmplitude_m = 0.5e-3;

struct HandedRun {
  // What the run holds.
  double length_s = 12.0;
  double rate_hz = 200.0;
  double jitter = 0.1;                      // of an interval: how far instants are off an even grid, at most
  double noise = 1e-5;                      // of the amplitude, standard deviation
  double gap_from_s = 0.0, gap_to_s = 0.0;  // the table's channel says nothing
  std::string label = "cold <b>start</b> & \"quoted\"";
  std::vector<record::StoredEvent> events;
  std::vector<record::StoredModel> models;
  std::vector<record::KeptFile> files;  // that its rig file names
  bool closed = true;

  // What was written.
  std::string path;
  std::vector<Record> stream;
  std::vector<Dwell> dwells;
};

// Seeded. Throws where it fails.
void write(HandedRun& run, const std::string& path);

// The table's displacement and the reaction at an instant of the run's axis, SI.
[[nodiscard]] double true_table_m(double t_s);
[[nodiscard]] double true_reaction_N(double t_s);

[[nodiscard]] handon::Selection select(const HandedRun& run, const handon::Range& range = {});
[[nodiscard]] handon::Provenance provenance();

// Samples as lines "channel t_ns raw_bits flags t_half_ns", for readers in Python; t_ns on the run's axis.
void dump_samples(const HandedRun& run, const std::string& path);

// Runs tests/handon/SCRIPT with these arguments and the system's Python; its exit code. 77: a package is missing.
[[nodiscard]] int python(const std::string& script, const std::vector<std::string>& arguments);

}  // namespace dwell::test
