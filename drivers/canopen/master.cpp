#include "drivers/canopen/master.hpp"

#include <poll.h>

#include <cstring>
#include <utility>

namespace dwell::canopen {
namespace {

using driver::monotonic_ns;
using driver::raw_ns;
using driver::Stop;
using socketcan::Controller;
using socketcan::Frame;
using socketcan::Link;
using socketcan::Receipt;

constexpr std::int64_t kWatchLink_ns = 100'000'000;
constexpr int kMostBatches = 64;

}  // namespace

Master::Master(const Setup& setup, const driver::Host& host, socketcan::Open open)
    : host_(host), bus_(setup.interface, std::move(open)), network_(setup, host), controller_(host) {}

void Master::run(Stop& stop) {
  while (!stop.requested()) {
    if (!bus_.is_open()) {
      open(stop);
      continue;
    }
    if (stop.wait(bus_.descriptor(), POLLIN, network_.next_ns(monotonic_ns())) == Stop::Wait::stopped) break;
    read(stop);
    if (!bus_.is_open()) continue;
    const std::int64_t now_ns = monotonic_ns();
    watch_link(now_ns);
    network_.tick(now_ns);
    if (send_pending() && network_.sync_due(now_ns)) send_sync(now_ns);
  }
  bus_.close();
}

// A link may come up, and a controller leave the bus, without a word.
void Master::watch_link(std::int64_t now_ns) {
  if (now_ns < next_link_ns_) return;
  next_link_ns_ = now_ns + kWatchLink_ns;
  const Link link = bus_.link();
  if (!network_.held()) {
    if (link == Link::no_carrier)
      network_.hold(DWELL_FAULT_BUS_OFF, bus_.name() + ": the interface has no carrier: bus-off, unless restarted");
  } else if (link == Link::up && bus_.controller() != Controller::bus_off &&
             (link_ != Link::up || now_ns >= next_try_ns_)) {
    network_.begin(now_ns);
  }
  link_ = link;
}

void Master::open(Stop& stop) {
  // One that has just failed may do so again as soon.
  if (!stop.sleep_until(next_try_ns_)) return;
  const std::string error = bus_.open();
  if (error.empty()) {
    controller_.begin();
    link_ = Link::up;
    network_.begin(monotonic_ns());
    return;
  }
  disconnected(error);
}

void Master::disconnected(const std::string& reason) {
  host_.count(DWELL_FAULT_DISCONNECTED);
  network_.hold(DWELL_FAULT_DISCONNECTED, reason);
  next_try_ns_ = monotonic_ns() + reconnect_.next_ns();
}

// Until nothing more is waiting; a bus that never ceases does not keep SYNC from being sent.
void Master::read(const Stop& stop) {
  bool more = true;
  for (int i = 0; more && i < kMostBatches && !stop.requested(); ++i) {
    const Receipt receipt = bus_.read();
    more = receipt.more;
    take(receipt, monotonic_ns());
    stop.turn();
    if (receipt.error == 0) continue;
    break_off(receipt.error);
    return;
  }
}

void Master::break_off(int error) {
  disconnected(bus_.reason(error));
  // A link that is down comes up again under the same socket.
  if (error != ENETDOWN) bus_.close();
}

void Master::take(const Receipt& receipt, std::int64_t now_ns) {
  network_.lost(receipt.lost, now_ns);
  host_.count(DWELL_FAULT_BAD_FRAME, receipt.malformed);
  controller_.count(receipt);
  if (bus_.controller() == Controller::bus_off) {
    if (!network_.held())
      network_.hold(DWELL_FAULT_BUS_OFF, bus_.name() + ": bus-off; it must be restarted, or have restart-ms set");
  } else if (receipt.restarted && network_.held()) {
    network_.begin(now_ns);
  }
  controller_.log(bus_, now_ns);
  for (const Frame& frame : receipt.frames) {
    if (network_.held() && !receipt.bus_off) network_.begin(now_ns);
    if (!frame.own) reconnect_.reset();
    network_.take(frame, now_ns);
  }
}

// What finds no room now waits for the next turn. false: the bus is not there any more.
bool Master::send_pending() {
  const std::uint64_t dropped = network_.outbox().dropped();
  host_.count(DWELL_FAULT_OVERFLOW, dropped - std::exchange(dropped_, dropped));
  while (const can_frame* const frame = network_.outbox().front()) {
    const int error = bus_.write(wide(*frame));
    if (error == ENOBUFS || error == EAGAIN || error == EINTR) break;
    if (error != 0) {
      break_off(error);
      return false;
    }
    network_.outbox().pop();
  }
  return true;
}

void Master::send_sync(std::int64_t now_ns) {
  static constexpr can_frame kFrame{kSync, {0}, 0, 0, 0, {}};
  const std::int64_t before_ns = raw_ns();
  const int error = bus_.write(wide(kFrame));
  if (error == 0)
    network_.sync_sent(before_ns, raw_ns(), now_ns);
  else
    network_.sync_failed(std::strerror(error));
}

}  // namespace dwell::canopen
