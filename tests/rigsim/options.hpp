// Everything a simulated rig is made from: the chain, its drive, where it is served, and the faults it has. Plain data
// with defaults: the clamped rig of three masses at 4 Hz.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/model/chain.hpp"
#include "core/model/driven_chain.hpp"
#include "tests/rigsim/bent_chain.hpp"
#include "tests/rigsim/knocks.hpp"

namespace rigsim {

// Probabilities are per request, on a CAN bus per frame. All of these can be changed while running (control.hpp) by the
// names in `kFaultNames`.
struct Faults {
  double noise = 0.0;      // standard deviation, relative to each channel's steady amplitude under the first drive
  double quantize = 0.0;   // step, relative likewise
  double invalid = 0.0;    // probability, per channel and reading, of no number (NaN; integers: the lowest code)
  double latency_s = 0.0;  // the device's turnaround
  double latency_jitter_s = 0.0;  // uniform 0 … this on top of it
  double exception = 0.0;         // probability of exception 4 (server device failure)
  double missing = 0.0;           // probability of no answer
  double dropout = 0.0;           // probability that the device falls silent for …
  double dropout_length_s = 0.2;  // … so long
  double late = 0.0;          // probability that the answer comes, while the device goes on with other requests, …
  double late_by_s = 0.5;     // … so much later
  double short_frame = 0.0;   // probability of half a frame
  double bad_crc = 0.0;       // probability of a wrong CRC (RTU)
  double wrong_id = 0.0;      // probability of another transaction's id (TCP), another station's address (RTU)
  double reset = 0.0;         // probability that the connection is reset instead of answered (TCP)
  double sync_missing = 0.0;  // probability, per period of the drive, of no sync pulse
  double sync_twice = 0.0;    // … of a second one a quarter of a period later
  double babble_hz = 0.0;     // meaningless frames of the highest priority per second (CAN)
};

struct FaultName {
  const char* name;
  double Faults::*member;
  double highest;  // 0 … highest is accepted
  const char* help;
};
// Bounded list of all of them, for the command line and the control lines.
[[nodiscard]] const std::vector<FaultName>& fault_names();

struct Options {
  dwell::Chain chain{dwell::Boundary::clamped, {12, 8, 5}, {24000, 8000, 6000, 8000}, {60, 45, 30, 40}};
  dwell::Drive drive{4.0, 0.005, 0.0, 0.25, {}};
  Bend bend;                       // what the chain has beside masses, springs and dampers
  std::vector<Knocking> knocks;    // on its masses
  std::vector<std::string> lines;  // control lines of the device that hold from the beginning
  bool from_steady = false;        // begin in the steady state instead of at rest
  bool stopped = false;            // the drive awaits `start`
  bool millimetres = false;        // float stations deliver mm instead of m
  double clock_drift_ppm = 0.0;    // of the rig's clock against the host's
  Faults faults;
  std::uint64_t seed = 1;

  std::optional<std::uint16_t> tcp_port = 0;  // 0: the kernel chooses; none: no TCP
  std::string tcp_host = "127.0.0.1";
  bool rtu = false;      // serve RTU on a pseudo-terminal
  std::string rtu_link;  // symbolic link to make to it; empty: none
  int baud = 0;          // of the simulated wire; 0: what the client sets
  bool parity = true;    // likewise; a pseudo-terminal does not tell the client's (11 bits a character; without: 10)
  std::string can;       // CAN interface, or unix:PATH for a local one; empty: none
  std::string canopen;   // likewise for the CANopen nodes
  double can_rate_hz = 200;  // frames per second and channel
  std::string control_path;  // unix stream socket for control lines; empty: none

  // The host's clock, ns; CLOCK_MONOTONIC_RAW unless a test brings its own. Called from the server's thread.
  std::function<std::int64_t()> clock_ns;
};

}  // namespace rigsim
