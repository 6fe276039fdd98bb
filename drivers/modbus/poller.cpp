#include "drivers/modbus/poller.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "drivers/common/words.hpp"

namespace dwell::modbus {
namespace {

using driver::monotonic_ns;
using driver::seconds;
using driver::Stop;

// A TCP connection on which nothing came to so many requests is taken for dead: the device may have been restarted.
constexpr int kSilencesToReconnect = 3;

// How long one fault of a block keeps the line from the other blocks.
std::int64_t cost_ns(const Setup& setup, const Block& block) {
  return setup.timeout_ns + setup.late_ns + setup.wire.time_ns(kRequestBytes + answer_bytes(block.count));
}

// Retries of failing blocks together shall take at most a twentieth of the time.
std::int64_t longest_retry_ns(const Setup& setup, const Block& block) {
  return std::max<std::int64_t>(driver::Backoff::kLongest_ns,
                                20 * static_cast<std::int64_t>(setup.blocks.size()) * cost_ns(setup, block));
}

// A gateway that says so for the device behind it: costs as much as a device that says nothing.
bool is_absent(const Answer& answer) {
  return answer.fault != DWELL_FAULT_EXCEPTION || answer.exception == MODBUS_EXCEPTION_GATEWAY_PATH ||
         answer.exception == MODBUS_EXCEPTION_GATEWAY_TARGET;
}

std::vector<Reading> readings_of(const Setup& setup) {
  std::vector<Reading> readings;
  for (const Block& block : setup.blocks) readings.insert(readings.end(), block.readings.begin(), block.readings.end());
  return readings;
}

}  // namespace

std::string reason_of(const Answer& answer, const Block& block, const Setup& setup) {
  if (answer.fault == DWELL_FAULT_DISCONNECTED)
    return setup.address() + ": " + (answer.error == 0 ? "disconnected" : modbus_strerror(answer.error));
  const std::string station = "station " + std::to_string(block.station) + ": ";
  switch (answer.fault) {
    case DWELL_FAULT_TIMEOUT:
      return station + "no answer within " + seconds(setup.timeout_ns);
    case DWELL_FAULT_EXCEPTION: {
      const bool known = answer.exception > 0 && answer.exception < MODBUS_EXCEPTION_MAX;
      return station + "registers " + std::to_string(block.first) + " to " + std::to_string(block.end() - 1) +
             ": exception " + std::to_string(answer.exception) +
             (known ? std::string(", ") + modbus_strerror(MODBUS_ENOBASE + answer.exception) : "");
    }
    case DWELL_FAULT_BAD_CHECKSUM:
      return station + "the answer arrives damaged (CRC)";
    case DWELL_FAULT_SHORT_FRAME:
      return station + "the answer is too short";
    default:
      return station + "what arrives does not answer the request";
  }
}

Poller::Poller(Setup setup, const driver::Host& host)
    : setup_(std::move(setup)),
      host_(host),
      link_(setup_),
      delivery_(host, readings_of(setup_)),
      registers_(kMaxRegisters) {
  std::size_t first = 0;
  for (const Block& block : setup_.blocks) {
    polled_.push_back({block, first, driver::Backoff(longest_retry_ns(setup_, block)), {}});
    first += block.readings.size();
  }
}

void Poller::run(Stop& stop) {
  warn_if_too_fast();
  while (!stop.requested()) {
    const std::string error = link_.open(stop);
    if (error.empty()) {
      poll(stop);
      link_.close();
    } else if (!stop.requested()) {
      delivery_.hold(DWELL_FAULT_DISCONNECTED, error);
    }
    if (stop.requested()) return;
    host_.count(DWELL_FAULT_DISCONNECTED);
    stop.sleep_for(reconnect_.next_ns());
  }
}

// Polls until stop or until the connection is of no more use.
void Poller::poll(Stop& stop) {
  silences_ = 0;
  for (Polled& polled : polled_) polled.not_before_ns = 0;
  const auto period_ns = std::max<std::int64_t>(1, std::llround(1e9 / setup_.rate_hz));
  std::int64_t next_ns = monotonic_ns();
  while (stop.sleep_until(next_ns)) {
    for (Polled& polled : polled_) {
      if (polled.not_before_ns > 0 && monotonic_ns() < polled.not_before_ns) continue;
      if (!read(polled, stop)) return;
    }
    next_ns += period_ns;
    const std::int64_t missed = (monotonic_ns() - next_ns) / period_ns;
    if (missed <= 0) continue;
    next_ns += missed * period_ns;
    host_.count(DWELL_FAULT_MISSED_DEADLINE, static_cast<std::uint64_t>(missed));
  }
}

// One transaction. false: stop, or the connection is of no more use.
bool Poller::read(Polled& polled, const Stop& stop) {
  const Answer answer = link_.read(polled.block, registers_.data(), stop);
  host_.count(DWELL_FAULT_LATE_ANSWER, answer.late);
  if (answer.stopped || stop.requested()) return false;
  if (answer.fault == DWELL_FAULT_NONE) {
    deliver(polled, answer);
    reconnect_.reset();
    silences_ = 0;
    return true;
  }
  if (answer.fault == DWELL_FAULT_DISCONNECTED) {
    delivery_.hold(DWELL_FAULT_DISCONNECTED, reason_of(answer, polled.block, setup_));
    return false;
  }
  host_.count(answer.fault);
  note_failure(polled, answer);
  const bool nothing_came = answer.fault == DWELL_FAULT_TIMEOUT && answer.late == 0;
  silences_ = nothing_came ? silences_ + 1 : 0;
  return !answer.broken && (setup_.transport == Transport::rtu || silences_ < kSilencesToReconnect);
}

void Poller::deliver(Polled& polled, const Answer& answer) noexcept {
  const Block& block = polled.block;
  const Stamp when = stamp(answer.sent_ns, answer.received_ns, setup_.wire.time_ns(kRequestBytes),
                           setup_.wire.time_ns(answer_bytes(block.count)));
  polled.failures.end();
  polled.not_before_ns = 0;
  polled.backoff.reset();
  for (std::size_t i = 0; i < block.readings.size(); ++i) {
    const Reading& reading = block.readings[i];
    const double value =
        decode(&registers_[reading.first - static_cast<unsigned>(block.first)], reading.type, reading.order);
    if (std::isfinite(value))
      delivery_.add(polled.first + i, {when.t_ns, when.t_half_ns}, value);
    else
      delivery_.fail(polled.first + i, DWELL_FAULT_INVALID_VALUE, monotonic_ns(),
                     [] { return "the device answers with what is not a finite number"; });
  }
  delivery_.push();
}

void Poller::note_failure(Polled& polled, const Answer& answer) {
  const std::int64_t now_ns = monotonic_ns();
  const bool lasts = polled.failures.add(now_ns);
  if (lasts && is_absent(answer) && polled_.size() > 1) polled.not_before_ns = now_ns + polled.backoff.next_ns();
  const std::string reason = lasts ? reason_of(answer, polled.block, setup_) : "";
  for (std::size_t i = polled.first; i < polled.first + polled.block.readings.size(); ++i) {
    if (lasts)
      delivery_.tell(i, answer.fault, reason);
    else
      delivery_.lost(i);
  }
}

void Poller::warn_if_too_fast() const {
  const double most_hz = most_rate_hz(setup_);
  if (most_hz == 0.0 || setup_.rate_hz <= most_hz) return;
  char text[160];
  std::snprintf(text, sizeof text, "%s: rate %g Hz is more than the line can carry; %.3g Hz is the most at %d baud",
                setup_.serial.c_str(), setup_.rate_hz, most_hz, setup_.baud);
  host_.log(DWELL_WARNING, text);
}

}  // namespace dwell::modbus
