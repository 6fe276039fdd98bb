// What the method of any motion reports (docs/method.md, Any motion): coefficients from a stretch of readings, steady
// or not, and how well the chain explains these readings. Plain data; the object `motion` of the public interface.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/result/dwell.hpp"
#include "core/result/missing.hpp"

namespace dwell {

struct MotionChannel {
  int channel = 0;            // index into Rig::channels
  double u_noise = kNaN;      // standard deviation of a reading's noise, SI, as estimated
  double chi2 = kNaN;         // mean of e²/S of the innovations: 1 where the noise is what it seems
  double whiteness_p = kNaN;  // Ljung-Box over 10 lags: small where the innovations are not white
  double unexplained =
      kNaN;  // part of the channel's own rms that is neither the model's nor noise from reading to reading
};

struct MotionEstimate {
  std::string reason;  // why there are no elements; empty: there are
  double start_s = kNaN, end_s = kNaN;
  std::vector<ElementEstimate> elements;
  std::vector<double> covariance;  // row-major, of [c, r] of the identifiable elements
  std::vector<double> u_of_noise;  // standard uncertainties of [c, r] of all elements by noise alone
  std::vector<MotionChannel> channels;
  std::size_t readings = 0;            // that count
  int passes = 0;                      // of the filter
  std::vector<MissingTerm> missing;    // likeliest first; one is named, and what cannot be told from it
  std::vector<std::string> unchecked;  // what these readings cannot tell whatever they show
  std::vector<std::string> warnings;
};

}  // namespace dwell
