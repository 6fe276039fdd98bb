#include "drivers/can/reader.hpp"

#include <poll.h>

#include <utility>

#include "drivers/common/words.hpp"

namespace dwell::can {
namespace {

using driver::monotonic_ns;
using driver::Stop;
using socketcan::Controller;
using socketcan::Frame;
using socketcan::Receipt;

constexpr std::int64_t kWatch_ns = 20'000'000;

}  // namespace

Reader::Reader(Setup setup, const driver::Host& host, socketcan::Open open)
    : setup_(std::move(setup)),
      host_(host),
      decoder_(setup_.wanted),
      bus_(setup_.interface, std::move(open)),
      controller_(host),
      delivery_(host, setup_.channels),
      heard_(setup_.channels.size()) {
  bus_.use_hardware_stamps(setup_.hardware_stamps);
}

void Reader::run(Stop& stop) {
  while (!stop.requested()) {
    if (!bus_.is_open()) {
      open(stop);
      continue;
    }
    if (stop.wait(bus_.descriptor(), POLLIN, next_watch_ns_) == Stop::Wait::stopped) break;
    read(stop);
  }
  bus_.close();
}

void Reader::open(Stop& stop) {
  const std::string error = bus_.open();
  if (error.empty()) {
    now_ns_ = monotonic_ns();
    release();
    controller_.begin();
    return;
  }
  disconnected(error);
  stop.sleep_for(reconnect_.next_ns());
}

// Until nothing more is waiting. A bus that never ceases must not keep us from seeing which channels are silent.
void Reader::read(const Stop& stop) {
  for (bool more = true; more && !stop.requested();) {
    const Receipt receipt = bus_.read();
    more = receipt.more;
    now_ns_ = monotonic_ns();
    take(receipt);
    if (receipt.error != 0) {
      disconnected(bus_.reason(receipt.error));
      more = false;
      // A link that is down comes up again under the same socket. A new one may fail as soon: not without a pause.
      link_down_ = receipt.error == ENETDOWN;
      if (!link_down_) {
        bus_.close();
        stop.sleep_for(reconnect_.next_ns());
      }
    }
    if (now_ns_ >= next_watch_ns_) watch_silence();
    stop.turn();
  }
}

void Reader::take(const Receipt& receipt) {
  delivery_.overflow(receipt.lost, bus_.name(), now_ns_);
  host_.count(DWELL_FAULT_BAD_FRAME, receipt.malformed);
  if (delivery_.held() && !receipt.frames.empty() && !receipt.bus_off) release();
  for (const Frame& frame : receipt.frames) deliver(frame);
  controller_.count(receipt);
  if (receipt.errors == 0 && !receipt.restarted) return;
  if (bus_.controller() == Controller::bus_off)
    delivery_.hold(DWELL_FAULT_BUS_OFF, bus_.name() + ": bus-off; it must be restarted, or have restart-ms set");
  else if (receipt.restarted)
    release();
}

// The path of a sample: nothing here allocates unless a state changes.
void Reader::deliver(const Frame& frame) noexcept {
  for (const Reading& reading : decoder_.decode(frame.can)) {
    if (reading.verdict == Verdict::absent) continue;
    heard_[reading.wanted].seen_ns = now_ns_;
    if (reading.verdict != Verdict::value) {
      fail(reading.wanted, reading.verdict);
      continue;
    }
    note_source(reading.wanted, frame.can.can_id);
    delivery_.add(reading.wanted, {frame.stamp.t_ns, frame.stamp.t_half_ns, frame.stamp.replaced}, reading.value);
  }
  if (delivery_.push()) reconnect_.reset();
}

void Reader::fail(std::size_t channel, Verdict verdict) noexcept {
  const bool is_short = verdict == Verdict::short_frame;
  delivery_.fail(channel, is_short ? DWELL_FAULT_SHORT_FRAME : DWELL_FAULT_INVALID_VALUE, now_ns_, [&] {
    return setup_.channels[channel].source +
           (is_short ? ": the frames end before the signal" : ": the frames hold what is not a number");
  });
}

void Reader::note_source(std::size_t channel, canid_t id) {
  const Match& match = decoder_.wanted(channel).match;
  if (!match.j1939 || match.source >= 0 || told_sources_) return;
  const int source = static_cast<int>(id & 0xFFU);
  const int before = std::exchange(heard_[channel].source, source);
  if (before < 0 || before == source) return;
  told_sources_ = true;
  host_.log(DWELL_WARNING, setup_.channels[channel].source + " comes from the addresses " + std::to_string(before) +
                               " and " + std::to_string(source) +
                               ": if these are two devices, `source` must say which is meant");
}

void Reader::disconnected(const std::string& reason) {
  host_.count(DWELL_FAULT_DISCONNECTED);
  delivery_.hold(DWELL_FAULT_DISCONNECTED, reason);
}

// What held them is over: each has its own time anew to deliver.
void Reader::release() noexcept {
  if (!delivery_.held()) return;
  delivery_.release();
  link_down_ = false;
  for (Heard& heard : heard_) heard.seen_ns = now_ns_;
}

// A link may come up without a frame: then it is no longer the link that keeps them away.
void Reader::watch_link() {
  if (!bus_.is_open() || bus_.link() == socketcan::Link::down) return;
  host_.log(DWELL_INFO, bus_.name() + ": the link is up again");
  release();
}

void Reader::watch_silence() {
  next_watch_ns_ = now_ns_ + kWatch_ns;
  if (bus_.hardware_stamps() && !told_hardware_) {
    told_hardware_ = true;
    host_.log(DWELL_INFO, bus_.name() + ": the interface stamps its frames itself");
  }
  if (bus_.is_open()) controller_.log(bus_, now_ns_);
  if (link_down_) watch_link();
  if (delivery_.held()) return;
  for (std::size_t i = 0; i < heard_.size(); ++i) {
    const Channel& channel = setup_.channels[i];
    if (delivery_.told(i) == DWELL_FAULT_TIMEOUT || now_ns_ - heard_[i].seen_ns < channel.timeout_ns) continue;
    host_.count(DWELL_FAULT_TIMEOUT);
    std::string reason = channel.source + ": no frame for " + driver::seconds(channel.timeout_ns);
    if (bus_.is_open() && bus_.link() == socketcan::Link::no_carrier)
      reason += "; the interface has no carrier: bus-off, unless restarted";
    delivery_.tell(i, DWELL_FAULT_TIMEOUT, reason);
  }
}

}  // namespace dwell::can
