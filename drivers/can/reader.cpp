#include "drivers/can/reader.hpp"

#include <poll.h>

#include <algorithm>
#include <cstdio>

namespace dwell::can {
namespace {

using driver::monotonic_ns;
using driver::Stop;
using socketcan::Controller;
using socketcan::Frame;
using socketcan::Receipt;

constexpr int kFailuresToStale = 3;
constexpr std::int64_t kWatch_ns = 20'000'000;
// A bus in trouble says so thousands of times a second.
constexpr std::int64_t kBetweenLines_ns = 1'000'000'000;

std::string seconds(std::int64_t ns) {
  char text[32];
  std::snprintf(text, sizeof text, "%g s", static_cast<double>(ns) * 1e-9);
  return text;
}

}  // namespace

Reader::Reader(Setup setup, const driver::Host& host, socketcan::Open open)
    : setup_(std::move(setup)), host_(host), decoder_(setup_.wanted), bus_(setup_.interface, std::move(open)) {
  for (const Channel& channel : setup_.channels) targets_.push_back({channel});
  scan_.reserve(targets_.size());
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
    release();
    now_ns_ = monotonic_ns();
    for (Target& target : targets_) target.seen_ns = now_ns_;
    told_controller_ = Controller::active;
    return;
  }
  host_.count(DWELL_FAULT_DISCONNECTED);
  hold(DWELL_FAULT_DISCONNECTED, error);
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
      host_.count(DWELL_FAULT_DISCONNECTED);
      hold(DWELL_FAULT_DISCONNECTED, bus_.reason(receipt.error));
      more = false;
      // A link that is down comes up again under the same socket. A new one may fail as soon: not without a pause.
      link_down_ = receipt.error == ENETDOWN;
      if (!link_down_) {
        bus_.close();
        stop.sleep_for(reconnect_.next_ns());
      }
    }
    if (now_ns_ >= next_watch_ns_) watch_silence(now_ns_);
    stop.turn();
  }
}

void Reader::take(const Receipt& receipt) {
  if (receipt.lost > 0) note_losses(receipt);
  host_.count(DWELL_FAULT_BAD_FRAME, receipt.malformed);
  if (held_ && !receipt.frames.empty() && !receipt.bus_off) release();
  for (const Frame& frame : receipt.frames) deliver(frame);
  if (receipt.errors > 0 || receipt.restarted) note_controller(receipt);
}

// The path of a sample: nothing here allocates unless a state changes.
void Reader::deliver(const Frame& frame) noexcept {
  scan_.clear();
  for (const Reading& reading : decoder_.decode(frame.can)) {
    Target& target = targets_[reading.wanted];
    if (reading.verdict == Verdict::absent) continue;
    target.seen_ns = now_ns_;
    if (reading.verdict != Verdict::value) {
      fail(target, reading.verdict);
      continue;
    }
    target.failures = 0;
    if (target.told != DWELL_FAULT_NONE) tell(target, DWELL_FAULT_NONE, nullptr);
    std::int64_t t_ns = frame.stamp.t_ns;
    unsigned flags = (frame.stamp.replaced ? DWELL_SAMPLE_STAMP_REPLACED : 0U) | (target.gap ? DWELL_SAMPLE_GAP : 0U);
    if (t_ns <= target.last_ns) {
      t_ns = target.last_ns + 1;
      flags |= DWELL_SAMPLE_STAMP_REPLACED;
    }
    target.last_ns = t_ns;
    target.gap = false;
    note_source(target, frame.can.can_id);
    scan_.push_back(
        {t_ns, reading.value, frame.stamp.t_half_ns, target.channel.index, static_cast<std::uint16_t>(flags)});
  }
  if (!scan_.empty()) {
    reconnect_.reset();
    host_.push(scan_);
  }
}

void Reader::fail(Target& target, Verdict verdict) noexcept {
  const dwell_fault fault = verdict == Verdict::short_frame ? DWELL_FAULT_SHORT_FRAME : DWELL_FAULT_INVALID_VALUE;
  host_.count(fault);
  target.failures = std::min(target.failures + 1, kFailuresToStale);
  if (target.failures < kFailuresToStale || target.told == fault) return;
  const std::string reason =
      target.channel.source + (fault == DWELL_FAULT_SHORT_FRAME ? ": the frames end before the signal"
                                                                : ": the frames hold what is not a number");
  tell(target, fault, reason.c_str());
}

void Reader::note_losses(const Receipt& receipt) {
  host_.count(DWELL_FAULT_OVERFLOW, receipt.lost);
  lost_ += receipt.lost;
  for (Target& target : targets_) target.gap = true;
  if (now_ns_ < next_loss_line_ns_) return;
  host_.log(DWELL_WARNING, bus_.name() + ": " + std::to_string(lost_) + " frames were lost for lack of room");
  lost_ = 0;
  next_loss_line_ns_ = now_ns_ + kBetweenLines_ns;
}

void Reader::note_controller(const Receipt& receipt) {
  const unsigned off = receipt.bus_off ? 1 : 0;
  host_.count(DWELL_FAULT_BUS_OFF, off);
  host_.count(DWELL_FAULT_BUS_ERROR, std::max(receipt.errors, off) - off);
  restarted_ = restarted_ || receipt.restarted;
  if (bus_.controller() == Controller::bus_off)
    hold(DWELL_FAULT_BUS_OFF, bus_.name() + ": bus-off; it must be restarted, or have restart-ms set");
  else if (receipt.restarted)
    release();
}

void Reader::tell_controller() {
  const Controller now = bus_.controller();
  if ((now == told_controller_ && !restarted_) || now_ns_ < next_controller_line_ns_) return;
  host_.log(now > told_controller_ ? DWELL_WARNING : DWELL_INFO,
            bus_.name() + ": the controller " + (restarted_ ? "was restarted, and is " : "is ") + to_string(now));
  told_controller_ = now;
  restarted_ = false;
  next_controller_line_ns_ = now_ns_ + kBetweenLines_ns;
}

void Reader::note_source(Target& target, canid_t id) {
  const Match& match = decoder_.wanted(static_cast<std::size_t>(&target - targets_.data())).match;
  if (!match.j1939 || match.source >= 0 || told_sources_) return;
  const int source = static_cast<int>(id & 0xFFU);
  if (target.source >= 0 && target.source != source) {
    told_sources_ = true;
    host_.log(DWELL_WARNING, target.channel.source + " comes from the addresses " + std::to_string(target.source) +
                                 " and " + std::to_string(source) +
                                 ": if these are two devices, `source` must say which is meant");
  }
  target.source = source;
}

void Reader::hold(dwell_fault fault, const std::string& reason) {
  // A link goes down before its interface is removed: the last reason counts.
  const bool another = !held_ || reason != held_reason_;
  held_ = true;
  held_reason_ = reason;
  for (Target& target : targets_) {
    target.gap = target.last_ns != INT64_MIN;
    if (another) tell(target, fault, reason.c_str());
  }
}

// What held them is over: each has its own time anew to deliver.
void Reader::release() noexcept {
  if (!held_) return;
  held_ = link_down_ = false;
  for (Target& target : targets_) target.seen_ns = now_ns_;
}

// A link may come up without a frame: then it is no longer the link that keeps them away.
void Reader::watch_link() {
  if (!bus_.is_open() || bus_.link() == socketcan::Link::down) return;
  host_.log(DWELL_INFO, bus_.name() + ": the link is up again");
  release();
}

void Reader::watch_silence(std::int64_t now_ns) {
  next_watch_ns_ = now_ns + kWatch_ns;
  if (bus_.hardware_stamps() && !told_hardware_) {
    told_hardware_ = true;
    host_.log(DWELL_INFO, bus_.name() + ": the interface stamps its frames itself");
  }
  if (bus_.is_open()) tell_controller();
  if (link_down_) watch_link();
  if (held_) return;
  for (Target& target : targets_) {
    if (target.told == DWELL_FAULT_TIMEOUT || now_ns - target.seen_ns < target.channel.timeout_ns) continue;
    host_.count(DWELL_FAULT_TIMEOUT);
    std::string reason = target.channel.source + ": no frame for " + seconds(target.channel.timeout_ns);
    if (bus_.is_open() && bus_.link() == socketcan::Link::no_carrier)
      reason += "; the interface has no carrier: bus-off, unless restarted";
    tell(target, DWELL_FAULT_TIMEOUT, reason.c_str());
  }
}

void Reader::tell(Target& target, dwell_fault fault, const char* reason) noexcept {
  target.told = fault;
  host_.state(target.channel.index, fault, reason);
}

}  // namespace dwell::can
