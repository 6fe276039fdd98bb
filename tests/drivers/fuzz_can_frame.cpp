// Whatever is wanted and whatever comes, the decoder gives finite numbers from within the frame, or a verdict; and the
// bus above it takes any packet, stamp and clock. The bytes are first what is wanted, then packets.
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "drivers/can/decoder.hpp"
#include "drivers/socketcan/bus.hpp"
#include "tests/drivers/fuzz_bytes.hpp"

namespace {

using namespace dwell;
using test::Bytes, test::hold;

can::Field some_field(Bytes& bytes) {
  can::Field field;
  const auto kind = bytes.take<std::uint8_t>();
  field.start = bytes.take<std::uint16_t>() % 512;
  field.length = static_cast<std::uint8_t>(1 + bytes.take<std::uint8_t>() % 64);
  field.order = (kind & 1U) != 0 ? can::Order::motorola : can::Order::intel;
  field.form = static_cast<can::Form>(kind >> 1U & 3U);
  if (field.form == can::Form::float32) field.length = 32;
  if (field.form == can::Form::float64) field.length = 64;
  if (can::bytes_of(field) > can::kMostBytes) field = {};
  return field;
}

can::Wanted some_wanted(Bytes& bytes) {
  can::Wanted wanted;
  const auto kind = bytes.take<std::uint8_t>();
  wanted.match.extended = (kind & 1U) != 0;
  wanted.match.j1939 = (kind & 3U) == 3U;
  wanted.match.source = (kind & 4U) != 0 && wanted.match.j1939 ? bytes.take<std::uint8_t>() : -1;
  wanted.match.id = bytes.take<std::uint32_t>() & (wanted.match.extended ? CAN_EFF_MASK : CAN_SFF_MASK);
  wanted.field = some_field(bytes);
  wanted.factor = 0.5;
  for (unsigned i = 0; i < (kind >> 3U & 3U); ++i) {
    const auto low = bytes.take<std::uint8_t>();
    wanted.conditions.push_back({some_field(bytes), {{low, std::uint64_t{low} + bytes.take<std::uint8_t>()}}});
  }
  return wanted;
}

// Hands out one packet a read.
class Script : public socketcan::Socket {
 public:
  explicit Script(Bytes& bytes) : bytes_(bytes) {}
  int descriptor() const noexcept override { return -1; }
  socketcan::Batch read(std::span<socketcan::Packet> room) noexcept override {
    socketcan::Packet& packet = room[0];
    packet.frame = bytes_.take<canfd_frame>();
    const auto kind = bytes_.take<std::uint8_t>();
    packet.size = (kind & 3U) == 0 ? kind >> 1U : (kind & 3U) == 1 ? CANFD_MTU : CAN_MTU;
    packet.real_ns = bytes_.take<std::int64_t>();
    packet.hardware_ns = bytes_.take<std::int64_t>();
    packet.own = (bytes_.take<std::uint8_t>() & 1U) != 0;
    return {1, 0, bytes_.take<std::uint8_t>()};
  }
  int write(const canfd_frame&, bool) noexcept override { return 0; }

 private:
  Bytes& bytes_;
};

std::int64_t the_raw_ns = 0, the_real_ns = 0;
socketcan::ClockPair the_clocks() noexcept { return {the_raw_ns += 1'000'000, the_real_ns, 100}; }

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes bytes(data, size);
  std::vector<can::Wanted> wanted;
  const std::size_t count = bytes.take<std::uint8_t>() % 8;
  for (std::size_t i = 0; i < count; ++i) wanted.push_back(some_wanted(bytes));
  can::Decoder decoder(wanted);
  the_raw_ns = 1'000'000'000;
  socketcan::Bus bus(
      "can0", [&]() -> socketcan::Opened { return std::make_unique<Script>(bytes); }, &the_clocks);
  hold(bus.open().empty());
  while (!bytes.empty()) {
    the_real_ns = bytes.take<std::int64_t>();
    const std::int64_t before_ns = the_raw_ns;
    const socketcan::Receipt receipt = bus.read();
    for (const socketcan::Frame& frame : receipt.frames) {
      hold(frame.can.len <= (frame.fd ? CANFD_MAX_DLEN : CAN_MAX_DLEN));
      hold(frame.stamp.t_ns <= the_raw_ns && frame.stamp.t_ns >= before_ns - 20'000'000);
      for (const can::Reading& reading : decoder.decode(frame.can)) {
        hold(reading.wanted < wanted.size());
        hold(reading.verdict != can::Verdict::value ||
             (std::isfinite(reading.value) && can::bytes_of(wanted[reading.wanted].field) <= frame.can.len));
      }
    }
  }
  return 0;
}
