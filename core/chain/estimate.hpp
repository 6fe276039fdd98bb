// From the phasors of all channels to the elements, with uncertainty by the GUM's law of propagation.
//
// Every source of error is a small vector: what one standard deviation of it does to all coefficients at once
// (docs/method.md, Uncertainty; first order, errors are assumed value minus true value). The covariance is the sum of
// the outer products, so correlations stay, and the budget is read off source by source.
//
//   δZ_k = [ ω² Σ_{i>=k} (m_i δY_i + Y_i δm_i) + 2ω Σ_{i>=k} m_i Y_i δω - δF - Z_k δd_k ] / d_k
//   δZ_{n+1} = (δF - Z_{n+1} δY_n) / Y_n
//   δc = Re δZ, δr = Im δZ / ω - r δω / ω
//   δY = noise + Y δs/s + jωY δτ - Y (q/ω + H'/H) δω
//
// Noise is type A with the degrees of freedom of its residuals; all else is type B with none to count (infinite); the
// effective degrees of freedom follow Welch and Satterthwaite (GUM G.4).
#pragma once

#include <Eigen/Core>
#include <array>
#include <complex>
#include <string>
#include <vector>

#include "core/fit/harmonic_fit.hpp"
#include "core/fit/scatter.hpp"
#include "core/result/dwell.hpp"
#include "core/rig/observation.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// What is known of one channel at the frequency of the drive.
struct Evidence {
  bool usable = false;
  std::string reason;                                    // why not
  std::array<std::complex<double>, kMaxHarmonics> X{};   // phasors of the reading at ω … Hω, SI
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  // of (Re X_1, Im X_1), white residuals
  double dof = 0.0;                                      // degrees of freedom behind that covariance
  double widened = 1.0;                                  // by what it is larger for the channel's own scatter
  std::vector<PhasorStretch> stretches;                  // give the scatter of each element
  PhasorSlope slope;
  std::complex<double>
      absorbed;  // of X_1: the answer to a change of the drive that may have been taken for a transient
  Eigen::Matrix2d transient = Eigen::Matrix2d::Zero();  // covariance by what is not known of the transient
  double quantization_u = 0.0;                          // of the reading, either component, the device's rounding
  double refresh_u_s = 0.0;                             // of the instants, by a slowly refreshed register, its own
  double folded_u = 0.0;                                // of the reading, either component, harmonics folded onto it
  double turnaround_u_s = 0.0;                          // standard uncertainty of the instants …
  int transaction = -1;  // … shared by all channels of one transaction (Transactions::of); -1: by none
};

struct Frequency {
  double omega = 0.0;    // rad/s
  double u = 0.0;        // rad/s, as measured or stated, against the host's clock
  double clock_u = 0.0;  // relative, of the clock
};

// What one standard deviation of a source of error makes of a channel's reading of any motion exp(st).
struct ReadingError {
  Eigen::Index channel;
  double relative = 0.0, late_s = 0.0;         // too small by that part; too late
  double lowpass_hz = 0.0, highpass_hz = 0.0;  // corners higher than stated
};
// By what part of itself the channel observes too little of a motion exp(st), s in rad/s.
[[nodiscard]] std::complex<double> observed_too_small(const Rig& rig, const ReadingError& error,
                                                      std::complex<double> s);

// What one standard deviation of a source of error does to [c_1, r_1, c_2, …] of all elements; 0 where not determined.
struct SourceEffect {
  Eigen::VectorXd on_coefficients;
  int mass = 0;                        // k of the mass that it is the uncertainty of; 0: of none
  double mass_u = 0.0;                 // that uncertainty, kg (kg·m²)
  double clock_u = 0.0;                // of the rate of the host's clock, which all times share; relative
  std::vector<ReadingError> readings;  // of scales, delays, filters, turnarounds and refreshed registers
};

struct ElementsResult {
  std::vector<ElementEstimate> elements;  // one per element of the chain
  std::vector<double> covariance;         // row-major, of [c, r] of the identifiable ones
  std::vector<std::string> warnings;
  std::vector<Doubt> doubts;
  std::vector<std::complex<double>> Z;  // N/m; NaN where not determined
  std::vector<SourceEffect> effects;    // the covariance source by source, for what is derived from the coefficients
  Eigen::MatrixXcd by_channel;          // elements × channels: δZ by a relative change of a channel's phasor
  Eigen::MatrixXd gain;                 // x by what the channels observe (core/rig/observation.hpp)
  Eigen::VectorXcd Y, d;                // phasors of Y_0 … Y_n and of the deformation of every element
};

// The channel's reading turned into what the chain sees: displacement or force on the ground, harmonic h of omega.
[[nodiscard]] std::complex<double> as_observed(const Rig& rig, int channel, std::complex<double> X, double omega,
                                               int h);

// The same of a motion exp(st), s in rad/s: amplitude a of a natural oscillation with the pole s.
[[nodiscard]] std::complex<double> as_observed(const Rig& rig, int channel, std::complex<double> a,
                                               std::complex<double> s);

// Weights 1/u of each channel for solve_observation, from noise and scale at the present phasors; 0 where not usable.
[[nodiscard]] Eigen::VectorXd observation_weights(const Rig& rig, const std::vector<Evidence>& evidence, double omega);

// All elements. gain: for the channels that are usable. Allocates; O(sources · elements²).
[[nodiscard]] ElementsResult estimate_elements(const Rig& rig, const Gain& gain, const std::vector<Evidence>& evidence,
                                               const Frequency& frequency);

}  // namespace dwell
