// What is reported of a model's verification (docs/method.md, Verification). Plain data; the JSON object of the public
// interface is this struct, field by field.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/result/dwell.hpp"
#include "core/result/missing.hpp"

namespace dwell {

enum class Verdict : std::uint8_t { adequate, not_adequate, not_verified };

[[nodiscard]] const char* to_string(Verdict verdict) noexcept;  // "adequate", "not adequate", "not verified yet"

// M and P of Sprague and Geers, C = √(M² + P²).
struct SpragueGeers {
  double magnitude = kNaN, phase = kNaN, combined = kNaN;
};

// Predicted against measured in one channel, over the evidence. Parts are of the channel's rms over the same readings.
struct ChannelComparison {
  int channel = -1;  // of Rig::channels
  Verdict verdict = Verdict::not_verified;
  std::string reason;  // why not verified; empty otherwise
  std::size_t samples = 0;
  double rms = kNaN;            // of what was measured, SI
  double error = kNaN;          // rms of predicted minus measured, as a part
  double U = kNaN;              // its expanded uncertainty (k = 2): coefficients, type B, initial state, table's noise
  double noise = kNaN;          // of what was measured, rms, as a part
  double beyond_steady = kNaN;  // how much of the prediction the steady phasors alone do not give, as a part
  double e_n = kNaN;
  double fit_percent = kNaN;
  double frac = kNaN;  // NaN: one frequency only
  SpragueGeers sprague_geers;
};

struct Verification {
  Verdict verdict = Verdict::not_verified;
  std::optional<bool> consistent;    // none: it could not be asked
  std::vector<std::string> reasons;  // of the verdict, in words with figures
  double e_n = kNaN;                 // the largest of the channels
  double chi2 = kNaN;                // reduced: weighted squares over what noise alone gives
  double p = kNaN;                   // probability of as much by chance
  double accuracy = kNaN;            // asked for
  double seen = kNaN, U = kNaN;      // of the channel that decides
  std::vector<ChannelComparison> channels;
  std::vector<MissingTerm> missing;            // likeliest first
  std::vector<std::string> evidence;           // "transient from 0.00 s to 6.42 s"
  std::vector<std::string> cannot_be_checked;  // what no data of this rig can tell
};

}  // namespace dwell
