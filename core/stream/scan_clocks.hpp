// The clocks of one device, applied to its samples.
//
// A device may deliver several streams, each at a rate of its own (the messages of a bus): the channels that come
// together, at one stamp, are one stream with one clock, and keep sharing one instant. With a clock of its own the
// samples come out at the recovered instants, a little later than they went in, since a few may have to be waited for
// (at most DeviceClock::kLongestHold_ns). Where the host is the clock they come out at once and unchanged, and the
// clocks only watch.
//
// Pure, virtual time, fixed memory after construction; bound to one thread. One clock update per scan.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/rig/rig.hpp"
#include "core/stream/device_clock.hpp"
#include "core/stream/record.hpp"

namespace dwell {

class ScanClocks {
 public:
  // What a merger must wait for a device with a clock of its own: what the clock holds, and a stall of the host.
  static constexpr std::int64_t kHoldBack_ns = DeviceClock::kLongestHold_ns + 150'000'000;

  // channels: Rig::channels indices of the device; rate_hz: what it is set to, 0: not known.
  ScanClocks(Clock clock, const std::vector<std::uint16_t>& channels, double rate_hz);

  // The next sample of the device, of one of its channels, in the order of arrival. Take all that pop() has before the
  // next call.
  void push(const Record& sample) noexcept;
  // It is now_ns, and all that has arrived has been pushed.
  void wait(std::int64_t now_ns) noexcept;
  // The device has stopped: whatever is held comes out.
  void flush() noexcept;
  // false: none is ready.
  bool pop(Record& out) noexcept;

  // Of the stream that carries the channel.
  [[nodiscard]] ClockFigures figures(std::uint16_t channel) const noexcept;

 private:
  // Samples held are nodes of one pool, each in one list: free, of a stream (undecided), or out (ready).
  struct Node {
    Record record;
    std::uint64_t scan = 0;
    int next = -1;
  };
  struct List {
    int first = -1, last = -1;
  };
  struct Stream {
    DeviceClock clock;
    List held;
    std::uint64_t decided = 0;     // the newest scan whose instant is known …
    DeviceClock::Instant instant;  // … and that instant
  };
  struct Place {
    int stream = -1;
    std::uint64_t scan = 0;  // the newest that held a sample of the channel
  };
  int take_first(List& list) noexcept;
  void append(List& list, int node) noexcept;
  void settle(Stream& stream) noexcept;
  void unite(int a, int b) noexcept;
  void give_out(int node, const DeviceClock::Instant& instant) noexcept;

  Clock kind_;
  std::vector<Place> places_;  // by Rig::channels index
  std::vector<Stream> streams_;
  std::size_t streams_used_ = 0;
  std::vector<Node> nodes_;
  List free_, out_;
  std::uint64_t scan_ = 0;  // the newest, its stream and its stamp
  int scan_stream_ = -1;
  std::int64_t scan_ns_ = 0;
};

}  // namespace dwell
