// The readings of all channels in bins of one width: the least and the greatest reading of each bin, and whether
// readings are missing there. A ring of fixed length; the newest bin takes the place of the oldest.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

namespace dwell {

// In the channel's own unit.
struct TraceBin {
  float low = std::numeric_limits<float>::infinity();  // above `high`: no reading came
  float high = -std::numeric_limits<float>::infinity();
  bool broken = false;  // readings are missing here, or are not shown: no line may be drawn to it or from it

  [[nodiscard]] bool empty() const noexcept { return low > high; }
  void take(float reading) noexcept {
    if (reading < low) low = reading;
    if (reading > high) high = reading;
  }
  void merge(const TraceBin& other) noexcept {
    if (other.low < low) low = other.low;
    if (other.high > high) high = other.high;
    broken = broken || other.broken;
  }
};

// Bins are numbered from 0, the bin at the axis' origin. Bound to one thread; allocates in the constructor alone.
class TraceBins {
 public:
  // Bins kept of each channel: at 20 ms 10.9 min, so that a page paused for 10 min misses nothing. 12 bytes each.
  static constexpr std::int64_t kBins = 32'768;

  explicit TraceBins(std::size_t channels) : bins_(channels * kBins), channels_(channels) {}

  // Numbers of the oldest bin kept and of the newest; -1: none yet.
  [[nodiscard]] std::int64_t oldest() const noexcept { return newest_ < kBins ? 0 : newest_ - kBins + 1; }
  [[nodiscard]] std::int64_t newest() const noexcept { return newest_; }

  // `number` becomes the newest bin; those in between are empty. Not below newest(). O(channels · bins passed).
  void advance(std::int64_t number) noexcept;
  // A bin that is kept: oldest() … newest().
  [[nodiscard]] TraceBin& at(std::size_t channel, std::int64_t number) noexcept {
    return bins_[place(channel, number)];
  }
  [[nodiscard]] const TraceBin& at(std::size_t channel, std::int64_t number) const noexcept {
    return bins_[place(channel, number)];
  }

 private:
  [[nodiscard]] static std::size_t place(std::size_t channel, std::int64_t number) noexcept {
    return channel * static_cast<std::size_t>(kBins) + static_cast<std::size_t>(number % kBins);
  }

  std::vector<TraceBin> bins_;  // by channel, then by number modulo kBins
  std::size_t channels_;
  std::int64_t newest_ = -1;
};

}  // namespace dwell
