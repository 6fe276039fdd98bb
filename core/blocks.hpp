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

#include "core/moments.hpp"

namespace dwell {

// All that a fit needs of one channel over a stretch, at one (ω, t_ref). `readings` are of s - reference.
struct ChannelMoments {
  const double* instants = nullptr;  // 2H+1 angles; M_0^0 is the number of samples
  const double* readings = nullptr;  // H+1 angles
  double sum_squares = 0.0;          // Σ (s - reference)²
};

// The sums over a range of blocks, filled by Blocks::sum; sized once.
class Totals {
 public:
  Totals(int channels, int harmonics);
  [[nodiscard]] ChannelMoments channel(int c) const noexcept;
  double omega = 0.0;  // rad/s
  std::int64_t t_ref_ns = 0;

 private:
  friend class Blocks;
  int instants_count_, readings_count_;
  std::vector<double> instants_, readings_, sum_squares_;
  std::vector<int> owner_;  // which channel's instants are meant
};

class Blocks {
 public:
  // channels, harmonics: 1 … 65535, 1 … kMaxHarmonics. All memory is allocated here: about
  // 48·(3H+2)·kCapacity·channels bytes.
  Blocks(int channels, int harmonics);

  static constexpr int kFine = 64;       // newest blocks that are never joined
  static constexpr int kPerLength = 12;  // blocks of one length kept before two of them are joined
  static constexpr int kCapacity = kFine + 1 + 16 * kPerLength;

  struct Block {
    std::int64_t begin_ns, end_ns;  // [begin, end)
    std::int64_t centre_ns;
    double omega;               // rad/s, at which its moments were taken
    std::int64_t first_serial;  // serial number of the first of the quarter blocks joined in it
    int quarters;               // how many quarter blocks
  };

  // Empties everything; channel c's readings are taken relative to reference[c] from now on.
  void clear() noexcept;
  // The value subtracted from a channel's readings, so that a large mean does not cost digits; fixed until clear().
  void set_reference(int channel, double value) noexcept { reference_[static_cast<std::size_t>(channel)] = value; }
  [[nodiscard]] double reference(int channel) const noexcept { return reference_[static_cast<std::size_t>(channel)]; }

  // Opens a block [begin, end) at omega; none may be open.
  void open(std::int64_t begin_ns, std::int64_t end_ns, double omega) noexcept;
  // Adds one sample to the open block. t within it and after the channel's previous sample. Cost: one sincos per
  // distinct instant, then about 6 (3H+2) multiply-adds. Real-time safe.
  void add(int channel, std::int64_t t_ns, double value) noexcept;
  // Closes the open block and joins old ones where there are too many. O(channels).
  void close() noexcept;
  [[nodiscard]] bool is_open() const noexcept { return open_; }
  [[nodiscard]] std::int64_t open_end_ns() const noexcept { return blocks_[current_].end_ns; }

  [[nodiscard]] int count() const noexcept { return static_cast<int>(order_.size()); }
  [[nodiscard]] const Block& block(int i) const noexcept { return blocks_[order_[static_cast<std::size_t>(i)]]; }
  // Serial number that the next closed quarter block gets; they count from 0 since clear().
  [[nodiscard]] std::int64_t serials() const noexcept { return serials_; }
  // Index of the first block that begins with or after the quarter block `serial`.
  [[nodiscard]] int index_of(std::int64_t serial) const noexcept;
  // Drops the oldest blocks that end at or before t.
  void forget_before(std::int64_t t_ns) noexcept;

  // Sums blocks [from, to) at (omega, t_ref), with the open block if with_open. O(blocks · channels · H).
  void sum(int from, int to, bool with_open, double omega, std::int64_t t_ref_ns, Totals& out) const noexcept;
  // The same for one channel alone; the other channels of `out` are left as they are.
  void sum_channel(int channel, int from, int to, bool with_open, double omega, std::int64_t t_ref_ns,
                   Totals& out) const noexcept;
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
    double count;          // samples so far
  };
  using Evaluate = void (*)(double, double, moments::Regressors&);
  using Add = void (*)(const moments::Regressors&, double, double*);

  [[nodiscard]] double* instants(std::size_t slot, int c) noexcept;
  [[nodiscard]] const double* instants(std::size_t slot, int c) const noexcept;
  [[nodiscard]] double* readings(std::size_t slot, int c) noexcept;
  [[nodiscard]] const double* readings(std::size_t slot, int c) const noexcept;
  [[nodiscard]] Slot& at(std::size_t slot, int c) noexcept;
  [[nodiscard]] const Slot& at(std::size_t slot, int c) const noexcept;

  void evaluate(std::int64_t t_ns, moments::Regressors& out) const noexcept;
  void settle_members(int leader) noexcept;
  void break_away(int c) noexcept;
  void regroup() noexcept;
  void join(std::size_t position) noexcept;
  void compact() noexcept;
  void sum_one(int channel, bool with_instants, int from, int to, bool with_open, double omega, std::int64_t t_ref_ns,
               Totals& out) const noexcept;
  void sum_instants(std::size_t slot, const Block& block, int c, double omega, std::int64_t t_ref_ns,
                    double* out) const noexcept;
  void sum_readings(std::size_t slot, const Block& block, int c, double omega, std::int64_t t_ref_ns,
                    double* out) const noexcept;

  int channels_, harmonics_, instants_count_, readings_count_;
  std::size_t instants_size_, readings_size_;
  std::vector<double> instants_, readings_;
  std::vector<Slot> slots_;
  std::vector<Block> blocks_;
  std::vector<std::uint16_t> order_, free_;  // slot numbers: in use, oldest first; unused
  std::vector<double> reference_;
  std::vector<Member> members_;
  bool open_ = false;
  std::size_t current_ = 0;  // slot of the open block
  std::int64_t serials_ = 0;
  moments::Regressors now_;
  Evaluate evaluate_ = nullptr;
  Add add_instant_ = nullptr, add_reading_ = nullptr;
};

}  // namespace dwell
