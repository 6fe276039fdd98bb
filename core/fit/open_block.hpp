// Fills the newest block: adds samples to the moments of their channels.
//
// Channels read at the same instants share one set of instants. The stream shows which: channels with identical
// instants in one block share in the next. A channel that misses an instant gets a set of its own for that block. So
// sharing saves work and never changes a result.
//
// All memory is allocated by the constructor. Bound to one thread; real-time safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/fit/moment_sets.hpp"
#include "core/fit/moments.hpp"
#include "core/fit/totals.hpp"

namespace dwell {

class OpenBlock {
 public:
  // channels: 1 … 65535; harmonics: 1 … kMaxHarmonics.
  OpenBlock(int channels, int harmonics);

  // Discards the open block. No channel shares instants in the next one.
  void reset() noexcept;
  // Value subtracted from a channel's readings.
  void set_reference(int channel, double value) noexcept { member(channel).reference = value; }
  [[nodiscard]] double reference(int channel) const noexcept { return member(channel).reference; }

  // Begins to fill a slot of `sets` and keeps pointers into it until close(). Angles are omega (t - centre), omega in
  // rad/s. Every sample must lie before the end.
  void open(MomentSets& sets, std::size_t slot, std::int64_t centre_ns, std::int64_t end_ns, double omega) noexcept;
  [[nodiscard]] bool is_open() const noexcept { return open_; }
  // The slot being filled, or the last one filled.
  [[nodiscard]] std::size_t slot() const noexcept { return slot_; }
  // Adds one sample. t lies after the channel's previous sample, and within about a quarter of a period of the centre.
  // Cost: 8 (2H+1) multiply-adds per distinct instant, 4 (H+1) per sample.
  void add(int channel, std::int64_t t_ns, double value) noexcept { add_sample_(*this, channel, t_ns, value); }
  // Completes the slot. O(channels · sets of instants).
  void close(MomentSets& sets) noexcept;

  // Adds the samples so far to `out`. turn: from this block to `out`.
  void add_to(Totals& out, const moments::Turn& turn) const noexcept;

 private:
  struct alignas(64) Member {  // per channel; a line of the cache, so that its place costs no multiplication
    int leader;                // channel whose set of instants it shares; itself: its own
    int next;                  // next channel with the same leader; -1: none
    std::int64_t last_ns;      // of a leader: newest instant in its set
    int size;                  // of a leader: channels in its group
    int arrived;               // of a leader: channels of its group that have brought the newest instant
    double count;              // samples so far
    double reference;          // subtracted from the readings
    double* instants;          // its own sets in the slot
    double* readings;
  };
  using Evaluate = void (*)(double, double, moments::Regressors&);
  using AddInstant = void (*)(const moments::Regressors&, double, double, double*);
  template <int H>
  static void add_sample(OpenBlock& block, int channel, std::int64_t t_ns, double value) noexcept;

  [[nodiscard]] Member& member(int c) noexcept { return members_[static_cast<std::size_t>(c)]; }
  [[nodiscard]] const Member& member(int c) const noexcept { return members_[static_cast<std::size_t>(c)]; }
  [[nodiscard]] int channels() const noexcept { return static_cast<int>(members_.size()); }
  // Set to which the instants of c are added.
  [[nodiscard]] const double* shared_instants(int c) const noexcept { return member(member(c).leader).instants; }
  void evaluate(std::int64_t t_ns, moments::Regressors& out) const noexcept;
  void settle_members(int leader) noexcept;
  void break_away(int c) noexcept;
  void regroup(const MomentSets& sets) noexcept;
  // Set of exactly the instants of c so far. `scratch` holds it where its group's set has one more.
  [[nodiscard]] const double* instants_of(int c, double* scratch) const noexcept;

  int instants_count_;
  std::vector<Member> members_;
  bool open_ = false;
  std::size_t slot_ = 0;
  std::int64_t centre_ns_ = 0, end_ns_ = 0;
  double omega_ = 0.0;
  moments::Regressors now_;
  // Inner loops compiled for this H.
  Evaluate evaluate_ = nullptr;
  AddInstant add_instant_ = nullptr;
  void (*add_sample_)(OpenBlock&, int, std::int64_t, double) = nullptr;
};

}  // namespace dwell
