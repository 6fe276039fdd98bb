// The rig as the method sees it: chain, drive, transducers. Plain data with defaults; config fills it from the rig
// file. All quantities SI (rad instead of m for rotation) unless a name says otherwise.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace dwell {

enum class Motion : std::uint8_t { translation, rotation };

// free: n elements, nothing beyond mass n. clamped: element n+1 ties mass n (n = 0: the table) to ground.
enum class Boundary : std::uint8_t { free, clamped };

// What a channel reads; the same words for rotation (angle, torque). Auxiliary channels are never identified.
enum class Quantity : std::uint8_t { displacement, velocity, acceleration, force, auxiliary };

enum class Reference : std::uint8_t { fixed, tracked, sync };

enum class FilterKind : std::uint8_t { none, butterworth, bessel, rc };

// A transducer's own low-pass or high-pass, unit gain in its pass band.
struct Filter {
  FilterKind kind = FilterKind::none;
  int order = 0;             // 1 … 8
  double hz = 0.0;           // -3 dB corner (rc: corner of each of `order` equal stages)
  double hz_u = 0.0;         // standard uncertainty of the corner, Hz
  bool hz_u_stated = false;  // a 0 is then a statement
};

inline constexpr int kGround = -1;  // Channel::at of the reaction force

struct Channel {
  std::string name;
  int device = -1;  // index into Rig::devices; -1: none (a recording as text)
  Quantity measures = Quantity::displacement;
  int at = 0;                      // 0 the table, k mass k, kGround the ground
  std::optional<int> relative_to;  // the reading is y_at - y_relative_to
  bool force_on_mass = false;      // force only: a positive reading is force on the mass, not on the ground
  std::string unit = "m";          // as in the rig file
  double si_per_unit = 1.0;        // value_SI = si_per_unit · (scale · raw + offset)
  double scale = 1.0;              // unit per raw
  double offset = 0.0;             // unit
  double scale_u = 0.0;            // standard uncertainty of the scale, relative
  double delay_s = 0.0;            // by which the reading lags the motion, device's delay not included
  double delay_u_s = 0.0;
  Filter lowpass;
  Filter highpass;
  std::optional<double> range_low;  // in `unit`; a reading beyond is overrange and not used
  std::optional<double> range_high;
  std::string calibration_id;
  std::string calibration_due;                          // ISO date
  bool scale_u_stated = false, delay_u_stated = false;  // a 0 is then a statement
};

// Whose clock the samples of a device follow. host: the stamps stand. device: it samples at a rate of its own and the
// stamps are arrivals, from which its clock is recovered.
enum class Clock : std::uint8_t { host, device };

// What all channels of one device share.
struct Device {
  std::string name;
  double delay_s = 0.0;
  double delay_u_s = 0.0;
  Clock clock = Clock::host;
  double rate_hz = 0.0;         // samples per second it is set to; 0: not known
  bool delay_u_stated = false;  // a 0 is then a statement
};

struct Excitation {
  double frequency_hz = 0.0;    // nominal
  double frequency_u_hz = 0.0;  // standard uncertainty of a fixed one
  double clock_u = 5e-5;        // relative standard uncertainty of the host's clock rate
  double minimum = 0.0;         // table amplitude (m, rad) below which the rig is idle
  double search_low_hz = 0.0;   // where a drive is looked for
  double search_high_hz = 0.0;
  Reference reference = Reference::tracked;
  int harmonics = 3;  // H, 1 … kMaxHarmonics
};

inline constexpr int kMaxHarmonics = 8;

struct Rig {
  std::string name;
  Motion motion = Motion::translation;
  Boundary boundary = Boundary::free;
  std::vector<double> masses;  // m_1 … m_n, kg (kg·m²)
  std::vector<double> mass_u;  // standard uncertainties, the same unit; empty: none stated
  Excitation excitation;
  double tolerance = 0.005;  // transient left, relative to each channel's steady amplitude
  double memory_s = 600.0;   // the longest stretch that counts
  double update_s = 0.1;     // between published estimates
  std::vector<Device> devices;
  std::vector<Channel> channels;

  [[nodiscard]] int mass_count() const noexcept { return static_cast<int>(masses.size()); }
  // Elements of the chain: n free, n + 1 clamped.
  [[nodiscard]] int element_count() const noexcept { return mass_count() + (boundary == Boundary::clamped ? 1 : 0); }
};

}  // namespace dwell
