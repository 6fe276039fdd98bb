// Report of a model's verification (docs/method.md, Verification). Plain data; the JSON object of the public interface
// is this struct, field by field.
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

// M, P and C = √(M² + P²) of Sprague and Geers (core/verify/comparison.hpp).
struct SpragueGeers {
  double magnitude = kNaN, phase = kNaN, combined = kNaN;
};

// Predicted against measured in one channel, over the evidence. error, noise, U, U_as_is and beyond_steady are parts
// of `rms`.
struct ChannelComparison {
  int channel = -1;  // index into Rig::channels
  Verdict verdict = Verdict::not_verified;
  std::string reason;  // why not verified; else empty
  std::size_t samples = 0;
  double rms = kNaN;      // of the measured readings, SI
  double error = kNaN;    // rms of predicted minus measured
  double noise = kNaN;    // part of `error` by noise: of the readings, and of the table's through the model
  double U = kNaN;        // expanded uncertainty (k = 2) of `error`: coefficients, type B, initial state, table's noise
  double U_as_is = kNaN;  // of √(error² - noise²), the coefficients taken as they are: type B of readings, noise
  double beyond_steady = kNaN;  // rms of the prediction minus the part that the steady phasors alone give
  double e_n = kNaN;            // normalized error, satisfactory up to 1
  double fit_percent = kNaN;
  double frac = kNaN;  // frequency response assurance criterion; NaN: one frequency only
  SpragueGeers sprague_geers;
};

struct Verification {
  Verdict verdict = Verdict::not_verified;
  std::optional<bool> consistent;    // noise and stated uncertainties explain the error; none: not tested
  std::vector<std::string> reasons;  // of the verdict, in words with figures
  double e_n = kNaN;                 // the largest of the channels
  double chi2 = kNaN;                // reduced χ²; the expectation comes from draws of all noise and error sources
  double p = kNaN;                   // probability that χ² and correlation are as large by chance
  double accuracy = kNaN;            // largest acceptable error as requested, part of rms
  double seen = kNaN, U = kNaN;      // error and its U of the channel that decides
  std::vector<ChannelComparison> channels;
  std::vector<MissingTerm> missing;            // likeliest first
  std::vector<std::string> evidence;           // "transient from 0.00 s to 6.42 s"
  std::vector<std::string> cannot_be_checked;  // properties that no data of this rig can show
};

// The verdict on a dwell's model, in short. Members as in Verification; asked: its `accuracy`.
struct ModelVerdict {
  Verdict verdict = Verdict::not_verified;
  std::optional<bool> consistent;
  double asked = kNaN, seen = kNaN, U = kNaN;  // parts of the rms of the channel that decides
  // What the method of any motion holds against the dwell (core/motion/dwell_agreement.hpp); empty: nothing, or it was
  // not asked yet.
  std::string objection{};
};
[[nodiscard]] ModelVerdict in_short(const Verification& verification) noexcept;

}  // namespace dwell
