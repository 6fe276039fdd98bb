#include "drivers/socketcan/bus.hpp"

#include <algorithm>
#include <cstring>

namespace dwell::socketcan {

const char* to_string(Controller state) noexcept {
  switch (state) {
    case Controller::active:
      return "error-active";
    case Controller::warning:
      return "error-warning";
    case Controller::passive:
      return "error-passive";
    case Controller::bus_off:
      return "bus-off";
  }
  return "";
}

Bus::Bus(std::string name, Open open, Clocks clocks)
    : name_(std::move(name)), open_(std::move(open)), clocks_(clocks), map_(clocks()) {}

std::string Bus::open() {
  close();
  const ClockPair before = clocks_();
  Opened opened = open_();
  if (!opened) return std::move(opened.error());
  socket_ = std::move(*opened);
  map_ = ClockMap(before);
  hardware_.reset();
  hardware_stamps_ = false;
  controller_ = Controller::active;
  dropped_ = 0;
  return {};
}

void Bus::close() noexcept { socket_.reset(); }

Stamp Bus::stamp_of(const Packet& packet) noexcept {
  Stamp stamp = map_.map(packet.real_ns);
  if (packet.hardware_ns == 0 || !use_hardware_) return stamp;
  const auto t_ns = hardware_.map(packet.hardware_ns, stamp.replaced ? std::nullopt : std::optional(stamp.t_ns));
  if (!t_ns || !map_.plausible(*t_ns)) return stamp;
  hardware_stamps_ = true;
  return {*t_ns, stamp.replaced ? map_.replacement().t_half_ns : stamp.t_half_ns, false};
}

void Bus::hear_error(const canfd_frame& frame, Receipt& receipt) noexcept {
  // A restart, or being error-active again, is good news.
  bool error = (frame.can_id & (CAN_ERR_MASK & ~(CAN_ERR_CRTL | CAN_ERR_RESTARTED | CAN_ERR_CNT))) != 0;
  if ((frame.can_id & CAN_ERR_CRTL) != 0) {
    const unsigned what = frame.data[1];
    if ((what & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE)) != 0)
      controller_ = Controller::passive;
    else if ((what & (CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING)) != 0)
      controller_ = Controller::warning;
    else if ((what & CAN_ERR_CRTL_ACTIVE) != 0)
      controller_ = Controller::active;
    if ((what & CAN_ERR_CRTL_RX_OVERFLOW) != 0) ++receipt.lost;
    error = error || (what & ~static_cast<unsigned>(CAN_ERR_CRTL_ACTIVE)) != 0;
  }
  if ((frame.can_id & CAN_ERR_RESTARTED) != 0) {
    controller_ = Controller::active;
    receipt.restarted = true;
  }
  if ((frame.can_id & CAN_ERR_BUSOFF) != 0) {
    controller_ = Controller::bus_off;
    receipt.bus_off = true;
  }
  if (error) ++receipt.errors;
}

Receipt Bus::read() noexcept {
  const ClockPair before = clocks_();
  const Batch batch = socket_->read(packets_);
  map_.read_at(clocks_());
  Receipt receipt;
  receipt.error = batch.error;
  receipt.more = batch.error == 0 && batch.count == packets_.size();
  receipt.lost = batch.dropped - dropped_;
  dropped_ = batch.dropped;
  std::size_t count = 0;
  for (std::size_t i = 0; i < std::min(batch.count, packets_.size()); ++i) {
    const Packet& packet = packets_[i];
    const bool fd = packet.size == CANFD_MTU;
    if (packet.size == 0) {
      receipt.error = ECONNRESET;
      receipt.more = false;
      break;
    }
    if ((!fd && packet.size != CAN_MTU) || packet.frame.len > (fd ? CANFD_MAX_DLEN : CAN_MAX_DLEN)) {
      ++receipt.malformed;
      continue;
    }
    if ((packet.frame.can_id & CAN_ERR_FLAG) != 0) {
      hear_error(packet.frame, receipt);
      continue;
    }
    // Whoever sends has not left the bus: the controller was restarted and we did not hear of it.
    if (controller_ == Controller::bus_off && !receipt.bus_off) controller_ = Controller::active;
    Frame& frame = frames_[count++];
    frame.can = packet.frame;
    frame.fd = fd;
    frame.own = packet.own;
    frame.stamp = stamp_of(packet);
  }
  if (!receipt.more) map_.empty_at(before);
  receipt.frames = {frames_.data(), count};
  return receipt;
}

std::string Bus::reason(int error) const {
  switch (error) {
    case ENETDOWN:
      return name_ + ": the link is down";
    case ENODEV:
    case ENXIO:
      return name_ + ": the interface was removed";
    case ECONNRESET:
      return name_ + ": the other end has closed";
    default:
      return name_ + ": " + std::strerror(error);
  }
}

}  // namespace dwell::socketcan
