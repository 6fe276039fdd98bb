// What the pipeline reports: one dwell, its phasors, its elements, each number with its uncertainty. Plain data.
// The JSON object of the public interface is this struct, field by field. SI units (rad, N·m … for rotation).
#pragma once

#include <complex>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/result/coefficient_error.hpp"

namespace dwell {

inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

enum class State : std::uint8_t { idle, settling, measuring, complete, fault };
enum class EndedBy : std::uint8_t { none, drive_changed, drive_stopped, interlock, data_lost, end, rearmed };

[[nodiscard]] const char* to_string(State state) noexcept;       // "idle", "settling", …
[[nodiscard]] const char* to_string(EndedBy ended_by) noexcept;  // "drive changed", …

// A number with its standard uncertainty (k = 1). NaN: no number.
struct Estimate {
  double value = kNaN;
  double u = kNaN;
};

// A coefficient: U95 is the half width of the 95 % interval for `dof` effective degrees of freedom.
struct Coefficient {
  double value = kNaN;
  double u = kNaN;
  double dof = kNaN;
  double U95 = kNaN;
  bool significant =
      false;  // |value| >= u; otherwise the value is shown, but nothing may rest on it (docs/method.md, Uncertainty)
};

// y(t) = amplitude · sin(2πf (t - t_ref) + phase) + mean, as the motion (the transducer's own response divided out).
struct ChannelPhasor {
  std::complex<double> Y{kNaN, kNaN};  // amplitude · exp(j phase), SI, in the channel's own quantity
  double u_amplitude = kNaN;
  double u_phase_rad = kNaN;
  // Standard uncertainty of the phase relative to the first valid channel; 0 for that channel. The turnaround of a
  // common transaction and the delay of a common device cancel. Often far below u_phase_rad.
  double u_relative_phase_rad = kNaN;
  double mean = kNaN;
  std::vector<double> harmonics;  // amplitudes of 2ω … Hω relative to the fundamental
  double sigma = kNaN;            // standard deviation of the residuals
  double samples = 0;             // how many stand behind it
  bool valid = false;
  std::string reason;  // why not valid
};

struct BudgetShare {
  std::string source;            // for instance "scale of y1"
  double stiffness_share = 0.0;  // parts of the variance; each column adds up to 1
  double damping_share = 0.0;
};

struct ElementEstimate {
  int k = 0;  // 1 …
  bool identifiable = false;
  std::string reason;               // why not
  Estimate deformation;             // |d_k|, m or rad
  Coefficient stiffness;            // N/m or N·m/rad
  Coefficient damping;              // N·s/m or N·m·s/rad
  Estimate loss_factor;             // ω r / c
  std::vector<BudgetShare> budget;  // largest first
};

// A reason why coefficients that are shown must not be relied on: what was seen, with figures, what was expected, and
// where to look. Names the channel or element and the cause.
struct Doubt {
  std::vector<int> elements;  // k of those concerned, ascending; empty: all
  std::string what;
};

struct Dwell {
  std::optional<int> index;  // 1 … within the run; none while idle
  State state = State::idle;
  EndedBy ended_by = EndedBy::none;
  double start_s = kNaN;                  // on the run's t axis: when this dwell was armed
  double settled_s = kNaN;                // the data count from here on; NaN: not settled
  double verdict_s = kNaN;                // when that was first said
  double end_s = kNaN;                    // the last datum that counts; live: so far
  double memory_time_s = kNaN;            // how long the transient took, as measured
  double memory_time_predicted_s = kNaN;  // the same from the eigenvalues of the identified chain
  double settles_in_s = kNaN;             // while settling: expected time left; NaN: not known
  std::string settling_reason;            // what the verdict rests on, or what is awaited
  Estimate frequency_hz;
  double t_ref_s = kNaN;                  // centroid of the data
  std::vector<ChannelPhasor> phasors;     // one per Rig::channels, in that order
  std::vector<ElementEstimate> elements;  // one per element when settled, else empty
  std::vector<double> covariance;         // row-major, of [c, r] of the identifiable elements in order
  std::vector<CoefficientError> errors;   // the same source by source; not part of the JSON object
  std::vector<std::string> warnings;
  std::vector<Doubt> doubts;
  std::vector<std::string>
      unstated;  // uncertainties that the rig file leaves out, so that no ± covers them: "scale of y1"
};

// Whether a dwell's coefficients may be relied on: settled, every element identifiable, no doubts. The one place that
// decides so: the lamp `ready`, exit codes and texts ask here. Thread-safe.
[[nodiscard]] bool trustworthy(const Dwell& dwell) noexcept;

}  // namespace dwell
