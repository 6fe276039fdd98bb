#include "tests/rigsim/bus_trouble.hpp"

#include <linux/can/error.h>

namespace rigsim {
namespace {

constexpr int kBabbleAtOnce = 200;
// What has not been sent for so long is not made up for.
constexpr std::int64_t kBabbleBehind_ns = 100'000'000;

void send_error(CanWire& wire, canid_t what, std::uint8_t state = 0) {
  WireFrame error;
  error.can.can_id = CAN_ERR_FLAG | what;
  error.can.len = CAN_ERR_DLC;
  error.can.data[1] = state;
  wire.send(error);
}

}  // namespace

std::optional<std::int64_t> BusTrouble::due_ns() const noexcept {
  if (faults_.babble_hz <= 0.0 || off_) return std::nullopt;
  return babble_ns_;
}

unsigned BusTrouble::babble(CanWire& wire, std::int64_t now_ns) {
  unsigned lost = 0;
  if (!due_ns()) return lost;
  if (babble_ns_ < now_ns - kBabbleBehind_ns) babble_ns_ = now_ns;
  for (int i = 0; i < kBabbleAtOnce && babble_ns_ <= now_ns; ++i) {
    WireFrame frame;
    frame.can.can_id = babble_;
    frame.can.len = 8;
    for (int k = 0; k < 8; ++k) frame.can.data[k] = static_cast<std::uint8_t>(random_());
    lost += wire.send(frame);
    babble_ns_ += static_cast<std::int64_t>(1e9 / faults_.babble_hz);
  }
  return lost;
}

std::optional<std::string> BusTrouble::command(const std::vector<std::string>& words, CanWire* wire) {
  if (words.size() != 1) return std::nullopt;
  if (words[0] == "bus-off") {
    if (wire != nullptr) send_error(*wire, CAN_ERR_BUSOFF);
    off_ = true;
  } else if (words[0] == "restart") {
    if (wire != nullptr && off_) send_error(*wire, CAN_ERR_RESTARTED);
    off_ = false;
  } else if (words[0] == "error-passive") {
    if (wire != nullptr) send_error(*wire, CAN_ERR_CRTL, CAN_ERR_CRTL_RX_PASSIVE);
  } else {
    return std::nullopt;
  }
  return "ok";
}

}  // namespace rigsim
