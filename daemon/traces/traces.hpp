// The traces of all channels, as pages draw them: the ordered stream in bins of fixed widths that all clients share.
//
//   readings ─┬─> the newest readings, made into bins of 0.3125, 1.25 and 5 ms when asked for
//             ├─> bins of 20 ms
//             ├─> bins of 80 ms
//             └─> bins of 320 ms, made into bins of 1.28 s, 5.12 s … when asked for
//
// Kept are 10.9 min in bins of 20 ms, 44 min of 80 ms, 2.9 h of 320 ms, and as many readings as 32 MB hold: 10 min of 4
// channels at 1 kHz, 42 s of 64 channels. Memory in all: 1.2 MB for each channel, and 32 MB at most.
//
// A bin holds its least and its greatest reading, and whether the trace is broken there: a reading is missing or not
// shown (lost, no longer kept, out of range, not a number that a float32 holds, stuck; the channel does not deliver),
// or the readings pause. Instants in seconds count from the first record, the origin.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/rig/rig.hpp"
#include "core/stream/record.hpp"
#include "daemon/traces/pause_finder.hpp"
#include "daemon/traces/steady_part.hpp"
#include "daemon/traces/trace_bins.hpp"
#include "daemon/traces/trace_readings.hpp"

namespace dwell {

// Virtual time. Bound to one thread, in dwelld the event loop's; no allocation per record.
class Traces {
 public:
  static constexpr std::int64_t kBin_ns = 20'000'000;       // the finest bins kept
  static constexpr std::int64_t kFinest_ns = kBin_ns / 64;  // the finest made from readings
  static constexpr std::int64_t kRatio = 4;                 // from one width to the next
  static constexpr std::size_t kReadingBytes = 32'000'000;

  explicit Traces(const Rig& rig);

  // The next record of the stream, as merged.
  void take(const Record& record) noexcept;
  // To be told that records before the next one were lost: every channel's trace breaks.
  void lost() noexcept;
  // on: the channel is stuck, so its readings are not shown from now on. off: they are shown again.
  void withhold(std::size_t channel, bool on) noexcept;

  // No record has come yet: there is no origin.
  [[nodiscard]] bool none() const noexcept { return bins_[0].newest() < 0; }
  [[nodiscard]] std::int64_t origin_ns() const noexcept { return origin_ns_; }
  [[nodiscard]] double seconds(std::int64_t t_ns) const noexcept {
    return static_cast<double>(t_ns - origin_ns_) * 1e-9;
  }
  [[nodiscard]] double newest_s() const noexcept { return seconds(newest_ns_); }
  // How many bins of 20 ms are complete since the origin: the number of the bin that is being filled.
  [[nodiscard]] std::int64_t complete() const noexcept { return none() ? 0 : bins_[0].newest(); }
  // Number of the oldest bin of 20 ms that is kept.
  [[nodiscard]] std::int64_t oldest() const noexcept { return bins_[0].oldest(); }
  // The bin of 20 ms of this number, oldest() to complete().
  [[nodiscard]] const TraceBin& bin(std::size_t channel, std::int64_t number) const noexcept {
    return bins_[0].at(channel, number);
  }

  // Bins of one of the fixed widths: bin number `first` begins first · step_ns after the origin.
  struct BinRange {
    std::int64_t step_ns = kBin_ns;
    std::int64_t first = 0;
    std::int64_t count = 0;
  };
  // From from_s to to_s in the finest width that is kept from from_s on and makes at most `points` bins (at least 1).
  // Where no width reaches back to from_s, the stretch begins later. Its newest bin may not be complete. Must not be
  // called while none().
  [[nodiscard]] BinRange stretch(double from_s, double to_s, std::int64_t points) const noexcept;
  // The same for read_less(): no further back than the readings of every channel are kept.
  [[nodiscard]] BinRange stretch_of_readings(double from_s, double to_s, std::int64_t points) const noexcept;
  // The bins of a channel. O(bins + readings in the stretch).
  [[nodiscard]] std::vector<TraceBin> read(const BinRange& stretch, std::size_t channel) const;
  // The same of the readings less the steady part; broken where the steady part does not hold.
  [[nodiscard]] std::vector<TraceBin> read_less(const BinRange& stretch, std::size_t channel,
                                                const SteadyPart& less) const;

 private:
  static constexpr std::array<std::int64_t, 3> kWidths_ns = {kBin_ns, kBin_ns* kRatio, kBin_ns* kRatio* kRatio};
  struct Trace {
    double scale, offset;  // to the channel's own unit
    double low, high;      // readings beyond are not shown
    bool withheld;
    PauseFinder pauses;
    TraceReadings readings;
  };

  void advance(std::int64_t t_ns) noexcept;
  void break_trace(std::size_t channel, std::int64_t t_ns) noexcept;
  [[nodiscard]] std::int64_t readings_from_ns() const noexcept;
  // Index of the kept width from which bins of step_ns are made.
  [[nodiscard]] static std::size_t level_of(std::int64_t step_ns) noexcept;
  [[nodiscard]] std::int64_t instant(double t_s) const noexcept;  // clamped to origin … newest record
  [[nodiscard]] BinRange cut(std::int64_t from_ns, std::int64_t to_ns, std::int64_t step_ns) const noexcept;
  template <class Shown>
  [[nodiscard]] std::vector<TraceBin> bins_of_readings(const BinRange& stretch, std::size_t channel, Shown shown) const;

  std::vector<Trace> traces_;  // by Rig::channels
  std::array<TraceBins, kWidths_ns.size()> bins_;
  std::int64_t origin_ns_ = 0, newest_ns_ = 0;
  std::int64_t bin_ends_ns_ = 0;  // of the newest bin of 20 ms
};

}  // namespace dwell
