// A simulated node's end of a CAN bus: a CAN interface, or a local SEQPACKET socket ("unix:PATH") that it makes and
// that others connect to, each packet being one can_frame or canfd_frame. The local one is the bus as well: what one
// client sends all others receive.
//
// Bound to one thread; nothing waits.
#pragma once

#include <linux/can.h>
#include <poll.h>

#include <memory>
#include <string>
#include <vector>

#include "drivers/socketcan/socket.hpp"
#include "tests/rigsim/sockets.hpp"

namespace rigsim {

inline constexpr std::size_t kMostFrames = 10'000;  // that a node keeps to be sent

struct WireFrame {
  canfd_frame can{};
  bool fd = false;
  std::int64_t real_ns = 0;  // the kernel's stamp of its arrival, CLOCK_REALTIME; 0: none
};

class CanWire {
 public:
  // Replaces a socket that was left behind. Says why not.
  [[nodiscard]] static Result<CanWire> open(const std::string& interface);
  CanWire(CanWire&&) = default;
  CanWire& operator=(CanWire&&) = default;
  ~CanWire();

  // Descriptors to wait for POLLIN on are appended.
  void watch(std::vector<pollfd>& polled) const;
  // Accepts clients, forwards between them, appends what came.
  void receive(std::vector<WireFrame>& frames);
  // Sends to all; a client without room loses it. How many lost it.
  unsigned send(const WireFrame& frame);
  [[nodiscard]] std::size_t clients() const noexcept { return clients_.size(); }

 private:
  CanWire() = default;
  void forward(const WireFrame& frame, const Fd* from, unsigned& lost);

  std::string path_;  // of the local socket; empty: an interface
  Fd listener_;
  std::vector<Fd> clients_;
  std::unique_ptr<dwell::socketcan::Socket> interface_;
};

}  // namespace rigsim
