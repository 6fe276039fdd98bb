// Description of a rig for the method: chain, drive, transducers. Plain data with defaults; `config` fills it from the
// rig file. All quantities are SI (rad instead of m for rotation) unless a name says otherwise.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace dwell {

enum class Motion : std::uint8_t { translation, rotation };

// free: n elements, nothing beyond mass n. clamped: element n+1 ties mass n (n = 0: the table) to ground.
enum class Boundary : std::uint8_t { free, clamped };

// What a channel measures; same words for rotation (angle, torque). The identification ignores auxiliary channels.
enum class Quantity : std::uint8_t { displacement, velocity, acceleration, force, auxiliary };

// Source of the drive's frequency. fixed: the rig file, as a prior; tracked: the measured motion; sync: sync pulses.
enum class Reference : std::uint8_t { fixed, tracked, sync };

enum class FilterKind : std::uint8_t { none, butterworth, bessel, rc };

// Low-pass or high-pass of a transducer, with unit gain in the pass band.
struct Filter {
  FilterKind kind = FilterKind::none;
  int order = 0;             // 1 … 8
  double hz = 0.0;           // -3 dB corner, Hz (rc: corner of each of `order` equal stages)
  double hz_u = 0.0;         // standard uncertainty of the corner, Hz
  bool hz_u_stated = false;  // the rig file states hz_u, even if as 0
};

inline constexpr int kGround = -1;  // the ground as a place: Channel::at of the reaction force

// In the channel's unit. Readings outside are not used.
struct MeasuringRange {
  std::optional<double> low;
  std::optional<double> high;
};

struct Calibration {
  std::string id;
  std::string due;  // ISO date
};

struct Channel {
  std::string name;
  int device = -1;  // index into Rig::devices; -1: none (a recording as text)
  Quantity measures = Quantity::displacement;
  int at = 0;                      // 0 the table, k mass k, kGround the ground
  std::optional<int> relative_to;  // the reading is y_at - y_relative_to
  bool force_on_mass = false;      // force only: a positive reading is the force on the mass, not on the ground
  std::string unit = "m";          // as in the rig file
  double si_per_unit = 1.0;        // value_SI = si_per_unit · (scale · raw + offset)
  double scale = 1.0;              // unit per raw
  double offset = 0.0;             // unit
  double scale_u = 0.0;            // standard uncertainty of the scale, relative
  double delay_s = 0.0;            // lag of the reading behind the motion, without Device::delay_s
  double delay_u_s = 0.0;          // its standard uncertainty
  Filter lowpass;
  Filter highpass;
  MeasuringRange range;
  Calibration calibration;
  struct {
    bool scale_u = false, delay_u = false;
  } stated;  // the rig file states it, even if as 0
};

// Clock that paces a device's samples. host: the stamps are the instants. device: the device samples at its own rate;
// the stamps are arrivals, and its clock is recovered from these.
enum class Clock : std::uint8_t { host, device };

// Properties that all channels of one device share.
struct Device {
  std::string name;
  double delay_s = 0.0;
  double delay_u_s = 0.0;
  Clock clock = Clock::host;
  double rate_hz = 0.0;         // sampling rate to which the device is set; 0: not known
  bool delay_u_stated = false;  // the rig file states delay_u_s, even if as 0
};

struct Excitation {
  double frequency_hz = 0.0;    // nominal
  double frequency_u_hz = 0.0;  // standard uncertainty of a `fixed` frequency
  double clock_u = 5e-5;        // relative standard uncertainty of the host's clock rate
  double minimum = 0.0;         // table amplitude (m, rad) below which the rig is idle
  double search_low_hz = 0.0;   // frequency range in which a drive is looked for
  double search_high_hz = 0.0;
  Reference reference = Reference::tracked;
  int harmonics = 3;  // H, 1 … kMaxHarmonics
};

inline constexpr int kMaxHarmonics = 8;

// A deviation of less than this part of Rig::tolerance is neither told nor counted against the drive. Halved: sound
// dwells get warnings. Doubled: an error of 0.2 of the tolerance goes unsaid.
inline constexpr double kToleranceShare = 0.1;

// low < high, SI. One of them may be infinite: there is no bound on that side.
struct Bounds {
  double low = 0.0;
  double high = 0.0;
};

// Between which values an element's coefficients are expected; operators are warned of others. The estimation does not
// look at it.
struct Limit {
  int element = 1;  // 1 … Rig::element_count(), once at most in Rig::limits
  std::optional<Bounds> stiffness;
  std::optional<Bounds> damping;
};

struct Rig {
  std::string name;
  Motion motion = Motion::translation;
  Boundary boundary = Boundary::free;
  std::vector<double> masses;  // m_1 … m_n, kg (kg·m²)
  std::vector<double> mass_u;  // standard uncertainties, same unit; empty: none stated
  Excitation excitation;
  double tolerance = 0.005;  // remaining transient that is allowed, relative to each channel's steady amplitude
  double memory_s = 600.0;   // the longest stretch of samples that counts; older data are forgotten
  double update_s = 0.1;     // interval between published estimates
  std::vector<Device> devices;
  std::vector<Channel> channels;
  std::vector<Limit> limits;

  [[nodiscard]] int mass_count() const noexcept { return static_cast<int>(masses.size()); }
  // n if free, n + 1 if clamped.
  [[nodiscard]] int element_count() const noexcept { return mass_count() + (boundary == Boundary::clamped ? 1 : 0); }
};

}  // namespace dwell
