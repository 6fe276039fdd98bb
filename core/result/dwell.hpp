// Report of the pipeline on one dwell: phasors and elements, each number with its uncertainty. Plain data. The JSON
// object of the public interface is this struct, field by field. SI units (rad, N·m … for rotation).
#pragma once

#include <complex>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/result/coefficient_error.hpp"
#include "core/result/kinds.hpp"

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

// A stiffness or damping. U95: half width of the 95 % interval, for `dof` effective degrees of freedom.
struct Coefficient {
  double value = kNaN;
  double u = kNaN;
  double dof = kNaN;
  double U95 = kNaN;
  bool significant = false;  // |value| >= u; if not, the value is shown but must not be used
};

enum class CoefficientKind : std::uint8_t { stiffness, damping };
[[nodiscard]] const char* to_string(CoefficientKind kind) noexcept;  // "stiffness", "damping"

// Motion at one channel: y(t) = amplitude · sin(2πf (t - t_ref) + phase) + mean, transducer's response divided out.
struct ChannelPhasor {
  std::complex<double> Y{kNaN, kNaN};  // amplitude · exp(j phase), SI, in the channel's own quantity
  double u_amplitude = kNaN;
  double u_phase_rad = kNaN;
  // Standard uncertainty of the phase relative to the first valid channel; 0 for that channel. Often far below
  // u_phase_rad, since the turnaround of a common transaction and the delay of a common device cancel.
  double u_relative_phase_rad = kNaN;
  double mean = kNaN;
  std::vector<double> harmonics;  // amplitudes of 2ω … Hω relative to the fundamental
  double sigma = kNaN;            // standard deviation of the residuals
  double samples = 0;             // number of samples in the fit
  bool valid = false;
  std::string reason;  // why not valid
};

struct BudgetShare {
  std::string source;            // for instance "scale of y1"
  double stiffness_share = 0.0;  // part of the variance of c; the shares of an element add up to 1
  double damping_share = 0.0;    // the same of r
  SourceKind kind = SourceKind::other;
  // Whose it is. SourceKind says which of these is set.
  std::string channel = {};  // name; empty: of no channel
  std::string device = {};   // name; empty: of no device
  int mass = 0;              // k, the nearest to the table is 1; 0: of no mass
};

struct ElementEstimate {
  int k = 0;  // 1 …
  bool identifiable = false;
  std::string reason;               // why not identifiable
  Estimate deformation;             // |d_k|, m or rad
  Coefficient stiffness;            // N/m or N·m/rad
  Coefficient damping;              // N·s/m or N·m·s/rad
  Estimate loss_factor;             // ω r / c
  std::vector<BudgetShare> budget;  // largest first
};

// A reason why coefficients that are shown must not be relied on. Says with figures what was seen, what was expected
// and where to look; names the channel or element and the cause.
struct Doubt {
  std::vector<int> elements;  // k of the elements concerned, ascending; empty: all
  std::string what;
  bool by_chance = false;  // noise alone may be the cause: nothing is to blame
};

// Something to know about a dwell whose coefficients may be relied on all the same.
struct Warning {
  WarningKind kind = WarningKind::other;
  std::string what;
  std::vector<int> elements = {};          // k of those that it names
  std::vector<std::string> channels = {};  // names of those that it names
  [[nodiscard]] bool operator==(const Warning&) const = default;
};
// How the text of a `not_settled` begins; Dwell::settling_reason follows.
inline constexpr const char* kNotSettled = "not settled: ";

struct Dwell {
  std::optional<int> index;  // 1 … within the run; none while idle
  State state = State::idle;
  EndedBy ended_by = EndedBy::none;
  double start_s = kNaN;                  // when this dwell was armed; on the run's t axis like all instants here
  double settled_s = kNaN;                // data count from here on; NaN: not settled
  double verdict_s = kNaN;                // instant of the verdict, at or after settled_s
  double end_s = kNaN;                    // last sample that counts; live: so far
  double memory_time_s = kNaN;            // duration of the transient as measured, from the beginning of the hold
  double memory_time_predicted_s = kNaN;  // the same from the eigenvalues of the identified chain
  double settles_in_s = kNaN;             // while settling: expected remaining time; NaN: not known
  std::string settling_reason;            // evidence for the verdict, or what the verdict still waits for
  Estimate frequency_hz;
  double t_ref_s = kNaN;                  // reference instant of phases: centroid of the data; by sync: a pulse near it
  std::vector<ChannelPhasor> phasors;     // one per Rig::channels, in that order
  std::vector<ElementEstimate> elements;  // one per element when settled, else empty
  std::vector<double> covariance;         // of (c, r) of each identifiable element in order; row-major
  std::vector<CoefficientError> errors;   // the covariance source by source; not part of the JSON object
  std::vector<Warning> warnings;
  std::vector<Doubt> doubts;
  std::vector<std::string> unstated;  // uncertainties that the rig file leaves out and no ± covers: "scale of y1"
};

// Estimate of the element k; null: the dwell has none yet. Points into the dwell. Thread-safe, no allocation.
[[nodiscard]] const ElementEstimate* element_of(const Dwell& dwell, int k) noexcept;

// Whether it has settled and tells of its elements. Thread-safe, no allocation.
[[nodiscard]] bool has_coefficients(const Dwell& dwell) noexcept;

// Whether the doubt concerns the element k. Thread-safe, no allocation.
[[nodiscard]] bool concerns(const Doubt& doubt, int k) noexcept;

// Whether a dwell's coefficients may be relied on: settled, every element identifiable, no doubts. The lamp `ready`,
// exit codes and texts all use this function. Thread-safe.
[[nodiscard]] bool trustworthy(const Dwell& dwell) noexcept;

}  // namespace dwell
