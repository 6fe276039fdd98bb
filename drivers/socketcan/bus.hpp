// One CAN bus as the drivers see it: frames with instants in CLOCK_MONOTONIC_RAW, what was lost, and what the
// controller says. Over any Socket; opens it anew as often as asked.
//
//   Bus bus("can0", [] { return open_socket("can0", filters); });
//   while (…) {
//     if (!bus.is_open()) { error = bus.open(); … }                    // empty: done
//     stop.wait(bus.descriptor(), POLLIN, deadline);
//     const Receipt receipt = bus.read();                              // also after a timeout: it keeps the clocks
//     near … if (receipt.error != 0 && receipt.error != ENETDOWN) bus.close();
//   }
//
// Bound to one thread. Nothing but open() allocates.
#pragma once

#include <array>
#include <cerrno>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "drivers/socketcan/clock_map.hpp"
#include "drivers/socketcan/hardware_clock.hpp"
#include "drivers/socketcan/socket.hpp"

namespace dwell::socketcan {

// A data or remote frame that came. `can.len` bytes of `can.data` are valid (at most 8, with fd at most 64).
struct Frame {
  canfd_frame can{};
  bool fd = false;
  bool own = false;  // Packet::own
  Stamp stamp;
};

// What the controller has said in error frames.
enum class Controller : std::uint8_t { active, warning, passive, bus_off };
[[nodiscard]] const char* to_string(Controller state) noexcept;

struct Receipt {
  std::span<const Frame> frames;  // valid until the next read
  bool more = false;              // there may be more waiting: read again before waiting
  std::uint32_t lost = 0;         // frames lost for lack of room in kernel or controller, before or among these
  unsigned malformed = 0;         // packets that are no frames
  unsigned errors = 0;            // error frames that speak of an error
  bool bus_off = false;           // the controller left the bus: nothing comes until it is restarted
  bool restarted = false;         // … and it was
  int error = 0;                  // errno of the socket, after those frames
};

class Bus {
 public:
  using Clocks = ClockPair (*)() noexcept;
  static constexpr std::size_t kBatch = 64;

  // `name`: as told to people. `clocks`: for tests.
  Bus(std::string name, Open open, Clocks clocks = &read_clocks);

  // Empty: done, else why not, in one line.
  [[nodiscard]] std::string open();
  void close() noexcept;
  [[nodiscard]] bool is_open() const noexcept { return socket_ != nullptr; }
  [[nodiscard]] int descriptor() const noexcept { return socket_->descriptor(); }
  [[nodiscard]] const std::string& name() const noexcept { return name_; }

  // One batch of what is waiting. Does not wait. While open.
  Receipt read() noexcept;
  // Sends one frame, does not wait: 0, or errno (Socket::write). While open.
  int write(const canfd_frame& frame, bool fd = false) noexcept { return socket_->write(frame, fd); }

  // While open.
  [[nodiscard]] Link link() const noexcept { return socket_->link(); }
  // The controller's state as told last; active after open.
  [[nodiscard]] Controller controller() const noexcept { return controller_; }
  // Whether the interface's own stamps are used where it has them; they are unless told otherwise.
  void use_hardware_stamps(bool use) noexcept { use_hardware_ = use; }
  // Do frames carry the interface's own stamps, and are these used?
  [[nodiscard]] bool hardware_stamps() const noexcept { return hardware_stamps_; }

  // "can0: the link is down"
  [[nodiscard]] std::string reason(int error) const;

 private:
  [[nodiscard]] Stamp stamp_of(const Packet& packet) noexcept;
  void hear_error(const canfd_frame& frame, Receipt& receipt) noexcept;

  std::string name_;
  Open open_;
  Clocks clocks_;
  std::unique_ptr<Socket> socket_;
  ClockMap map_;
  HardwareClock hardware_;
  bool use_hardware_ = true;
  bool hardware_stamps_ = false;
  Controller controller_ = Controller::active;
  std::uint32_t dropped_ = 0;
  std::array<Packet, kBatch> packets_{};
  std::array<Frame, kBatch> frames_{};
};

}  // namespace dwell::socketcan
