#include "tests/rigsim/responder.hpp"

#include <limits>

#include "tests/rigsim/stations.hpp"

namespace rigsim {

Responder::Responder(const Options& options)
    : device(options),
      float_scale_(options.millimetres ? 1e3 : 1.0),
      baud_(options.baud),
      silent_until_s_(-std::numeric_limits<double>::infinity()),
      random_(options.seed ^ 0x5DEECE66DULL),
      values_(device.channels().size()) {}

bool Responder::happens(double probability) {
  return probability > 0.0 && std::uniform_real_distribution<double>(0.0, 1.0)(random_) < probability;
}

Fate Responder::decide(const Request& request, double now_s, const Line* line) {
  ++tally.requests;
  const Faults& faults = device.faults;
  Fate fate;
  const auto unanswered = [&] {
    ++tally.unanswered;
    fate.kind = Fate::Kind::nothing;
    return fate;
  };
  if (silent || now_s < silent_until_s_) return unanswered();
  if (happens(faults.dropout)) {
    silent_until_s_ = now_s + faults.dropout_length_s;
    return unanswered();
  }
  if (line == nullptr && happens(faults.reset)) {
    ++tally.resets;
    fate.kind = Fate::Kind::reset;
    return fate;
  }
  if (happens(faults.missing)) return unanswered();
  double turnaround = faults.latency_s;
  if (faults.latency_jitter_s > 0.0)
    turnaround += std::uniform_real_distribution<double>(0.0, faults.latency_jitter_s)(random_);
  fate.exception = happens(faults.exception);
  fate.short_frame = happens(faults.short_frame);
  fate.bad_crc = happens(faults.bad_crc);
  fate.wrong_id = happens(faults.wrong_id);
  double before = 0.0, behind = 0.0;
  if (line != nullptr) {
    const double per_byte = line->bits / (baud_ > 0 ? baud_ : line->baud);
    const bool refused = fate.exception || request.exception != 0;
    before = per_byte * static_cast<double>(request.size);
    behind = per_byte * (refused ? 5.0 : 5.0 + 2.0 * request.count);
  }
  fate.sample_s = before + device.reading_faults().sampled_at(request.unit) * turnaround;
  fate.send_s = before + turnaround + behind;
  if (happens(faults.late)) {
    fate.send_s += faults.late_by_s;
    fate.out_of_turn = true;
  }
  return fate;
}

Bytes Responder::pdu(const Request& request, const Fate& fate, double t_s) {
  if (request.exception != 0) return exception_pdu(request, request.exception);
  if (fate.exception) return exception_pdu(request, kDeviceFailure);
  const auto type = station(request.unit);
  if (!type) return exception_pdu(request, kNoSuchTarget);
  const auto words = static_cast<std::size_t>(type->words());
  const std::size_t all = words * values_.size();
  if (std::size_t{request.address} + request.count > all) return exception_pdu(request, kIllegalAddress);
  device.read(t_s, values_, request.unit);
  registers_.resize(all);
  for (std::size_t i = 0; i < values_.size(); ++i) {
    const bool force = device.is_force(i);
    encode(values_[i], force, force ? 1.0 : float_scale_, *type, std::span(registers_).subspan(words * i, words));
  }
  return registers_pdu(request, std::span(registers_).subspan(request.address, request.count));
}

Bytes Responder::answer(const Request& request, const Fate& fate, double t_s, bool rtu) {
  // On a serial line nobody answers for a station that is not there.
  if (rtu && !station(request.unit)) {
    ++tally.unanswered;
    return {};
  }
  const Bytes body = pdu(request, fate, t_s);
  ++tally.answers;
  if ((body[0] & 0x80U) != 0) ++tally.exceptions;
  Bytes frame;
  if (rtu) {
    frame = rtu_frame(static_cast<std::uint8_t>(request.unit + (fate.wrong_id ? 1 : 0)), body);
    if (fate.bad_crc) frame.back() = static_cast<std::uint8_t>(frame.back() ^ 0x55U);
  } else {
    frame = tcp_frame(static_cast<std::uint16_t>(request.transaction + (fate.wrong_id ? 1 : 0)), request.unit, body);
  }
  if (fate.short_frame) frame.resize(frame.size() / 2);
  return frame;
}

}  // namespace rigsim
