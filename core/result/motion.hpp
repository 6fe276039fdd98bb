// Report of the method of any motion (docs/method.md, Any motion): coefficients from a stretch of readings, steady or
// not, and how well the chain explains these readings. Plain data; the object `motion` of the public interface.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/result/dwell.hpp"
#include "core/result/missing.hpp"

namespace dwell {

struct MotionChannel {
  int channel = 0;            // index into Rig::channels
  double u_noise = kNaN;      // standard deviation of a reading's noise, SI, as estimated
  double chi2 = kNaN;         // reduced χ² of the innovations, mean of e²/S; 1 if u_noise is right
  double whiteness_p = kNaN;  // p-value of the Ljung-Box test over 10 lags; small if the innovations are not white
  double unexplained = kNaN;  // rms explained neither by the model nor by noise between readings; part of channel's rms
};

// An error in the readings of a transducer of the table that is no noise: core/motion/pattern_in_noise.hpp.
struct ReadingsPattern {
  std::string channel;     // its name
  double at_least = kNaN;  // rms of the error is this or more, relative to the rms of the channel's motion; above 0
};

// The long part of the search for what the rig file lacks: the chain fitted anew with each thing that may be missing.
// It is asked for where the readings contradict the chain, or where its fit fails.
enum class AnewSearch : std::uint8_t { not_asked, put_off, done };

struct MotionEstimate {
  std::string reason;         // why there are no elements; empty: there are elements
  bool contradicted = false;  // the reason: the readings contradict the chain of the rig file
  double start_s = kNaN, end_s = kNaN;
  std::vector<ElementEstimate> elements;
  std::vector<double> covariance;  // of (c, r) of each identifiable element; row-major
  std::vector<double> u_of_noise;  // standard uncertainties of (c, r) of each element by noise alone
  std::vector<MotionChannel> channels;
  std::vector<ReadingsPattern> patterns;  // at most one of each of the table's channels; empty: none was found
  std::size_t readings = 0;               // number of readings that count
  int passes = 0;                         // of the Kalman filter over the readings
  std::vector<MissingTerm> missing;       // likeliest first; one is named, and what cannot be told from it
  std::vector<std::string> unchecked;     // what these readings cannot tell whatever they show
  AnewSearch anew = AnewSearch::not_asked;
  std::vector<std::string> warnings;
};

// How a motion's coefficients agree with those of a dwell of the same rig; core/motion/dwell_agreement.hpp. element,
// kind and over_U are of the coefficient that contradicts; if none does or several do, of the one that differs most.
struct Agreement {
  int element = 1;  // k
  CoefficientKind kind = CoefficientKind::stiffness;
  double over_U = 0.0;       // its |difference| / √(U95² + U95²)
  bool contradicts = false;  // that is above 1, and noise does not explain it
  double e_n = 0.0;          // of all coefficients the largest |difference| / (2 u of the difference, by noise alone)
};

}  // namespace dwell
