// The seam between the CAN drivers and where frames come from: a SocketCAN interface, a local socket that carries the
// same frames, or what a test makes up. Everything above it (bus.hpp) is the same for all of them.
//
// Frames are the kernel's own `canfd_frame`: can_id with its flags CAN_EFF_FLAG, CAN_RTR_FLAG, CAN_ERR_FLAG; a packet
// of CAN_MTU bytes is a classic frame, one of CANFD_MTU bytes a CAN FD one. Bound to one thread.
#pragma once

#include <linux/can.h>
#include <linux/can/error.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <tl/expected.hpp>

namespace dwell::socketcan {

// One packet as it was handed over, nothing of it checked.
struct Packet {
  canfd_frame frame{};
  std::size_t size = 0;          // bytes; CAN_MTU, CANFD_MTU, or not a frame; 0: the other end has closed
  std::int64_t real_ns = 0;      // the kernel's stamp of arrival, CLOCK_REALTIME; 0: none
  std::int64_t hardware_ns = 0;  // the interface's own stamp, in its own clock; 0: none
  bool own = false;              // sent by this very socket (OwnFrames::returned)
};

struct Batch {
  std::size_t count = 0;      // packets; fewer than there was room for: nothing more is waiting
  int error = 0;              // errno, after those packets; ENETDOWN: the socket lives on and works again after `up`
  std::uint32_t dropped = 0;  // frames that the kernel has dropped for lack of room since it was opened, modulo 2^32
};

enum class Link : std::uint8_t { up, no_carrier, down };

class Socket {
 public:
  virtual ~Socket() = default;
  // To wait for POLLIN on.
  [[nodiscard]] virtual int descriptor() const noexcept = 0;
  // Takes what is waiting. Neither waits nor allocates.
  virtual Batch read(std::span<Packet> room) noexcept = 0;
  // Sends one frame; does not wait. 0, or errno: ENOBUFS or EAGAIN (no room at the moment), ENETDOWN, ENODEV, …
  virtual int write(const canfd_frame& frame, bool fd) noexcept = 0;
  // How the interface stands; no_carrier: it is up, but its controller has left the bus. Up where that is not known.
  [[nodiscard]] virtual Link link() const noexcept { return Link::up; }
};

using Opened = tl::expected<std::unique_ptr<Socket>, std::string>;
using Open = std::function<Opened()>;

// What is to be received: frames whose (can_id & mask) == (id & mask), any of the list; the bits CAN_EFF_FLAG and
// CAN_RTR_FLAG belong into the mask. An empty list: everything. A local socket is not filtered, nor one with more
// entries than the kernel takes (512): whoever reads must be content with frames it did not ask for.
using Filters = std::span<const can_filter>;

// Whether what a socket sends comes back to it once the interface has sent it, with the stamp of then. Never from a
// local socket.
enum class OwnFrames : std::uint8_t { dropped, returned };

// Opens `interface`: the name of a CAN interface ("can0"), or "unix:PATH", a SEQPACKET socket that carries can_frame
// and canfd_frame, for simulators and tests. Does not wait. Says why not in one line.
[[nodiscard]] Opened open_socket(const std::string& interface, Filters filters, OwnFrames own = OwnFrames::dropped);

// What is wrong with an interface's name, or empty.
[[nodiscard]] std::string interface_fault(const std::string& interface);

}  // namespace dwell::socketcan
