// Between a request and its answer: which faults befall it, when it is sampled and sent, and its bytes. Virtual time.
#pragma once

#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "tests/rigsim/device.hpp"
#include "tests/rigsim/modbus_adu.hpp"
#include "tests/rigsim/sockets.hpp"

namespace rigsim {

// What becomes of one request. Delays count from its arrival.
struct Fate {
  enum class Kind : std::uint8_t { answer, nothing, reset };
  Kind kind = Kind::answer;
  double sample_s = 0.0;
  double send_s = 0.0;
  bool out_of_turn = false;  // late: the device goes on with other requests meanwhile
  bool exception = false, short_frame = false, bad_crc = false, wrong_id = false;
};

struct Tally {
  std::uint64_t requests = 0, answers = 0, exceptions = 0, unanswered = 0, resets = 0;
};

// Bound to one thread.
class Responder {
 public:
  explicit Responder(const Options& options);

  // now_s: any clock that goes on, for the length of drop-outs. line: of the wire; null: TCP.
  [[nodiscard]] Fate decide(const Request& request, double now_s, const Line* line);

  // The answer's frame, sampled at simulated time t. May be empty: nothing is answered.
  [[nodiscard]] Bytes answer(const Request& request, const Fate& fate, double t_s, bool rtu);

  Device device;
  bool silent = false;
  Tally tally;

 private:
  [[nodiscard]] bool happens(double probability);
  [[nodiscard]] Bytes pdu(const Request& request, const Fate& fate, double t_s);

  double float_scale_;
  int baud_;
  double silent_until_s_;
  std::mt19937_64 random_;
  std::vector<double> values_;
  std::vector<std::uint16_t> registers_;
};

}  // namespace rigsim
