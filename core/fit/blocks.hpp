// Condenses the samples of one dwell into a bounded sequence of blocks. A block holds the moments of all channels over
// a stretch of time.
//
// A new block is a quarter of a period long. The newest blocks stay as they are. Older neighbours are joined: lengths
// grow with age, and a fixed number of blocks holds any dwell (an exponential histogram). Forgetting, refining ω,
// admitting data after the fact and taking data back all act on blocks, not on samples. MomentSets holds the moments,
// OpenBlock fills the newest block.
#pragma once

#include <cstdint>
#include <vector>

#include "core/fit/moment_sets.hpp"
#include "core/fit/moments.hpp"
#include "core/fit/open_block.hpp"
#include "core/fit/totals.hpp"

namespace dwell {

inline constexpr int kQuarters = 4;  // blocks of a period

class Blocks {
 public:
  // channels: 1 … 65535; harmonics: 1 … kMaxHarmonics. Allocates all memory: about 32·(3H+4)·kCapacity·channels bytes.
  Blocks(int channels, int harmonics);

  static constexpr int kFine = 64;       // newest blocks, never joined
  static constexpr int kPerLength = 12;  // blocks of one length; beyond it the oldest two are joined
  // Lengths of 2 … 2^26 quarters. The longest alone hold 8e8, twice the longest memory of a rig file (1e8 periods).
  static constexpr int kLengths = 26;
  static constexpr int kCapacity = kFine + 1 + kLengths * kPerLength;

  struct Block {
    std::int64_t begin_ns, end_ns;  // [begin, end)
    std::int64_t centre_ns;
    double omega;               // ω of its moments, rad/s
    std::int64_t first_serial;  // serial number of its first quarter block
    int quarters;               // quarter blocks joined in it
  };

  // Drops all blocks; serial numbers begin at 0 again.
  void clear() noexcept;
  // Drops all blocks; serial numbers go on.
  void restart() noexcept;
  // Value subtracted from a channel's readings, so that a large mean costs no digits. Change it only after clear().
  void set_reference(int channel, double value) noexcept { newest_.set_reference(channel, value); }
  [[nodiscard]] double reference(int channel) const noexcept { return newest_.reference(channel); }

  // Opens a block [begin, end) at omega (rad/s). No block may be open.
  void open(std::int64_t begin_ns, std::int64_t end_ns, double omega) noexcept;
  // Adds one sample to the open block. t lies after the channel's previous sample and before the block's end. It may
  // lie a few readings before the block's begin, as a reading may wait for later ones. Cost: 8 (2H+1) multiply-adds per
  // distinct instant, 4 (H+1) per sample. Real-time safe.
  void add(int channel, std::int64_t t_ns, double value) noexcept { newest_.add(channel, t_ns, value); }
  // Closes the open block. Joins old blocks if there are too many; drops none. O(channels · (H + sets of instants)).
  void close() noexcept;
  [[nodiscard]] bool is_open() const noexcept { return newest_.is_open(); }
  [[nodiscard]] std::int64_t open_end_ns() const noexcept { return blocks_[newest_.slot()].end_ns; }

  [[nodiscard]] int count() const noexcept { return static_cast<int>(order_.size()); }
  [[nodiscard]] const Block& block(int i) const noexcept { return blocks_[order_[static_cast<std::size_t>(i)]]; }
  // Serial number that the next closed quarter block gets, counted from 0 since clear().
  [[nodiscard]] std::int64_t serials() const noexcept { return serials_; }
  // Index of the first block that begins with or after the quarter block `serial`; count() if there is none.
  [[nodiscard]] int index_of(std::int64_t serial) const noexcept;
  // Drops the oldest blocks that end at or before t. True: there were any.
  bool forget_before(std::int64_t t_ns) noexcept;

  // Drift of the drive's frequency. All later sums use the phase ω (t - t_ref) + rate (t - about)² / 2, rate in rad/s².
  // Drift within a block is ignored: the phase at its ends is off by rate·length²/8.
  struct Drift {
    double rate = 0.0;
    std::int64_t about_ns = 0;
  };
  void set_drift(const Drift& drift) noexcept { drift_ = drift; }
  [[nodiscard]] const Drift& drift() const noexcept { return drift_; }

  // Adds block i to `out`, at out's (ω, t_ref). O(channels · H), no allocation.
  void add_block(int i, Totals& out) const noexcept;
  // Adds the open block's samples so far; nothing if no block is open.
  void add_open(Totals& out) const noexcept;
  // Restarts `out` at (omega, t_ref) and adds blocks [from, to).
  void sum(int from, int to, double omega, std::int64_t t_ref_ns, Totals& out) const noexcept;
  // The same for one channel; the other channels of `out` keep their sums.
  void sum_channel(int channel, int from, int to, double omega, std::int64_t t_ref_ns, Totals& out) const noexcept;
  // Samples of a channel in block i.
  [[nodiscard]] double samples(int i, int channel) const noexcept;

 private:
  [[nodiscard]] moments::Turn turn_into(const Totals& out, std::size_t slot) const noexcept;
  [[nodiscard]] ChannelMoments sets_of(std::size_t slot, int c) const noexcept {
    return {sets_.shared_instants(slot, c), sets_.readings(slot, c)};
  }
  void join(std::size_t position) noexcept;
  void compact() noexcept;

  MomentSets sets_;
  OpenBlock newest_;
  std::vector<Block> blocks_;                // per slot
  std::vector<std::uint16_t> order_, free_;  // slot numbers: in use, oldest first; unused
  Drift drift_;
  std::int64_t serials_ = 0;
};

}  // namespace dwell
