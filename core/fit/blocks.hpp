// The samples of one dwell, condensed: a bounded sequence of blocks, each the moments of all channels over a stretch.
//
// New blocks are a quarter of a period long. The newest stay as they are; of older ones neighbours are joined, so that
// the lengths grow with age and a fixed number of blocks holds any dwell (as an exponential histogram does).
// Forgetting, refining ω, admitting data after the fact and taking data back all act on blocks, not on samples.
//
// Channels read at the same instants share one set of instants' moments: who shares is learned from the stream itself
// (channels whose instants were identical in one block share in the next), and a channel that misses an instant gets a
// set of its own for that block, so that sharing saves work and never changes a result.
#pragma once

#include <cstdint>
#include <vector>

#include "core/fit/moments.hpp"
#include "core/fit/totals.hpp"

namespace dwell {

inline constexpr int kQuarters = 4;  // blocks of a period

class Blocks {
 public:
  // channels, harmonics: 1 … 65535, 1 … kMaxHarmonics. All memory is allocated here: about
  // 48·(3H+2)·kCapacity·channels bytes.
  Blocks(int channels, int harmonics);

  static constexpr int kFine = 64;       // newest blocks that are never joined
  static constexpr int kPerLength = 12;  // blocks of one length kept before two of them are joined
  // Lengths of 2 … 2^26 quarters: 8e8 of them, twice the longest memory of a rig file (1e8 periods).
  static constexpr int kLengths = 26;
  static constexpr int kCapacity = kFine + 1 + kLengths * kPerLength;

  struct Block {
    std::int64_t begin_ns, end_ns;  // [begin, end)
    std::int64_t centre_ns;
    double omega;               // rad/s, at which its moments were taken
    std::int64_t first_serial;  // serial number of the first of the quarter blocks joined in it
    int quarters;               // how many quarter blocks
  };

  // Empties everything; channel c's readings are taken relative to reference[c] from now on.
  void clear() noexcept;
  // Empties everything, but serial numbers and references go on.
  void restart() noexcept;
  // The value subtracted from a channel's readings, so that a large mean does not cost digits; fixed until clear().
  void set_reference(int channel, double value) noexcept {
    members_[static_cast<std::size_t>(channel)].reference = value;
  }
  [[nodiscard]] double reference(int channel) const noexcept {
    return members_[static_cast<std::size_t>(channel)].reference;
  }

  // Opens a block [begin, end) at omega; none may be open.
  void open(std::int64_t begin_ns, std::int64_t end_ns, double omega) noexcept;
  // Adds one sample to the open block. t after the channel's previous sample; within the block, or a few readings
  // before it: a reading may wait until those after it have come. Cost: 8 (2H+1) multiply-adds per distinct instant,
  // then 4 (H+1). Real-time safe.
  void add(int channel, std::int64_t t_ns, double value) noexcept { add_sample_(*this, channel, t_ns, value); }
  // Closes the open block and joins old ones where there are too many; none is ever dropped. O(channels).
  void close() noexcept;
  [[nodiscard]] bool is_open() const noexcept { return open_; }
  [[nodiscard]] std::int64_t open_end_ns() const noexcept { return blocks_[current_].end_ns; }

  [[nodiscard]] int count() const noexcept { return static_cast<int>(order_.size()); }
  [[nodiscard]] const Block& block(int i) const noexcept { return blocks_[order_[static_cast<std::size_t>(i)]]; }
  // Serial number that the next closed quarter block gets; they count from 0 since clear().
  [[nodiscard]] std::int64_t serials() const noexcept { return serials_; }
  // Index of the first block that begins with or after the quarter block `serial`.
  [[nodiscard]] int index_of(std::int64_t serial) const noexcept;
  // Drops the oldest blocks that end at or before t; whether there were any.
  bool forget_before(std::int64_t t_ns) noexcept;

  // A drive whose frequency drifts: all sums from now on are of the phase ω (t - t_ref) + rate (t - about)² / 2,
  // rate in rad/s². Within a block the drift is left alone: its ends are off by rate·length²/8.
  struct Drift {
    double rate = 0.0;
    std::int64_t about_ns = 0;
  };
  void set_drift(const Drift& drift) noexcept { drift_ = drift; }
  [[nodiscard]] const Drift& drift() const noexcept { return drift_; }

  // Adds block i to `out`, at out's (ω, t_ref). O(channels · H), no allocation.
  void add_block(int i, Totals& out) const noexcept;
  // Adds what the open block holds so far; nothing if none is open.
  void add_open(Totals& out) const noexcept;
  // Restarts `out` at (omega, t_ref) and adds blocks [from, to).
  void sum(int from, int to, double omega, std::int64_t t_ref_ns, Totals& out) const noexcept;
  // The same for one channel alone; the others of `out` are left as they are.
  void sum_channel(int channel, int from, int to, double omega, std::int64_t t_ref_ns, Totals& out) const noexcept;
  // Samples of a channel in block i.
  [[nodiscard]] double samples(int i, int channel) const noexcept;

 private:
  struct Slot {  // per channel in a block
    double sum_squares;
    int owner;  // channel whose instants' moments it shares
  };
  struct Member {          // per channel, in the open block
    int leader;            // channel whose set is shared; itself: its own
    int next;              // next channel with the same leader, -1: none
    std::int64_t last_ns;  // of a leader: newest instant in its set
    int size;              // of a leader: channels in its group
    int arrived;           // of a leader: how many of them have brought the newest instant
    double count;          // samples so far
    double reference;      // subtracted from the readings
    double* instants;      // its own sets in the open block
    double* readings;
  };
  using Evaluate = void (*)(double, double, moments::Regressors&);
  using AddInstant = void (*)(const moments::Regressors&, double, double, double*);
  template <int H>
  static void add_sample(Blocks& blocks, int channel, std::int64_t t_ns, double value) noexcept;

  [[nodiscard]] double* instants(std::size_t slot, int c) noexcept;
  [[nodiscard]] const double* instants(std::size_t slot, int c) const noexcept;
  [[nodiscard]] double* readings(std::size_t slot, int c) noexcept;
  [[nodiscard]] const double* readings(std::size_t slot, int c) const noexcept;
  // Channel whose instants' moments c shares in a block.
  [[nodiscard]] int& owner(std::size_t slot, int c) noexcept;
  [[nodiscard]] int owner(std::size_t slot, int c) const noexcept;

  [[nodiscard]] moments::Turn turn_into(const Totals& out, std::size_t slot) const noexcept;
  void evaluate(std::int64_t t_ns, moments::Regressors& out) const noexcept;
  void settle_members(int leader) noexcept;
  void break_away(int c) noexcept;
  void regroup() noexcept;
  void join(std::size_t position) noexcept;
  void compact() noexcept;
  // Makes room in `out` for c's own instants where it can no longer share, before any block is added.
  void part(int c, int owner_in_block, Totals& out) const noexcept;
  [[nodiscard]] const double* open_instants(int c, double* scratch) const noexcept;

  int channels_, instants_count_, readings_count_;
  std::size_t instants_size_, readings_size_;
  std::vector<double> instants_, readings_;
  std::vector<int> owners_;
  std::vector<Block> blocks_;
  std::vector<std::uint16_t> order_, free_;  // slot numbers: in use, oldest first; unused
  std::vector<Member> members_;
  Drift drift_;
  bool open_ = false;
  std::size_t current_ = 0;  // slot of the open block
  std::int64_t serials_ = 0;
  moments::Regressors now_;
  // The inner loops know H at compile time; these are the right ones for this H.
  Evaluate evaluate_ = nullptr;
  AddInstant add_instant_ = nullptr;
  void (*add_sample_)(Blocks&, int, std::int64_t, double) = nullptr;
};

}  // namespace dwell
