// Applies the recovered clocks of one device to its samples.
//
// A device may deliver several streams (the messages of a bus), each at its own rate. Channels that arrive together, at
// one stamp, form one stream with one clock, and keep sharing one instant. With Clock::device the samples come out with
// their recovered instants. Some wait until theirs is decided, at most DeviceClock::kLongestHold_ns. With Clock::host
// they come out at once and unchanged, and the clocks only measure.
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
  // How long a merger must wait for a device with a clock of its own: the longest hold of the clock, and 150 ms for a
  // stall of the host.
  static constexpr std::int64_t kHoldBack_ns = DeviceClock::kLongestHold_ns + 150'000'000;

  // channels: Rig::channels indices of the device; rate_hz: the rate set in the device, 0: not known.
  ScanClocks(Clock clock, const std::vector<std::uint16_t>& channels, double rate_hz);

  // The next sample of one of the device's channels, in the order of arrival. Take all samples that pop() has ready
  // before the next call.
  void push(const Record& sample) noexcept;
  // It is now_ns, and all samples that have arrived have been pushed.
  void wait(std::int64_t now_ns) noexcept;
  // The device has stopped: all samples held come out.
  void flush() noexcept;
  // Moves the next ready sample to `out`; false: none is ready.
  bool pop(Record& out) noexcept;

  // Figures of the clock of the stream that carries the channel.
  [[nodiscard]] ClockFigures figures(std::uint16_t channel) const noexcept;

 private:
  // Samples held are nodes of one pool. Each is in one list: free, of a stream (undecided), or out (ready).
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
    std::uint64_t scan = 0;  // the newest scan with a sample of the channel
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
  std::uint64_t scan_ = 0;  // the newest scan, its stream and its stamp
  int scan_stream_ = -1;
  std::int64_t scan_ns_ = 0;
};

}  // namespace dwell
