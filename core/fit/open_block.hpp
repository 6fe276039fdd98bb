// The block that is being filled: adds samples to the moments of their channels.
//
// Channels read at the same instants share one set of instants' moments: who shares is learned from the stream itself
// (channels whose instants were identical in one block share in the next), and a channel that misses an instant gets a
// set of its own for that block, so that sharing saves work and never changes a result.
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
  // channels, harmonics: 1 … 65535, 1 … kMaxHarmonics.
  OpenBlock(int channels, int harmonics);

  // Ends it without a trace and lets every channel have a set of its own in the next.
  void reset() noexcept;
  // The value subtracted from a channel's readings.
  void set_reference(int channel, double value) noexcept { member(channel).reference = value; }
  [[nodiscard]] double reference(int channel) const noexcept { return member(channel).reference; }

  // Begins to fill a slot of `sets`, whose pointers it keeps until close(); angles are ω (t - centre), and no sample is
  // at or after the end.
  void open(MomentSets& sets, std::size_t slot, std::int64_t centre_ns, std::int64_t end_ns, double omega) noexcept;
  [[nodiscard]] bool is_open() const noexcept { return open_; }
  // The slot that is being filled, or was last.
  [[nodiscard]] std::size_t slot() const noexcept { return slot_; }
  // Adds one sample. t after the channel's previous sample and within a quarter of a period of the centre, about. Cost:
  // 8 (2H+1) multiply-adds per distinct instant, then 4 (H+1).
  void add(int channel, std::int64_t t_ns, double value) noexcept { add_sample_(*this, channel, t_ns, value); }
  // The slot is complete. O(channels).
  void close(MomentSets& sets) noexcept;

  // Adds what it holds so far to `out`.
  void add_to(Totals& out, const moments::Turn& turn) const noexcept;

 private:
  struct Member {          // per channel
    int leader;            // channel whose set is shared; itself: its own
    int next;              // next channel with the same leader, -1: none
    std::int64_t last_ns;  // of a leader: newest instant in its set
    int size;              // of a leader: channels in its group
    int arrived;           // of a leader: how many of them have brought the newest instant
    double count;          // samples so far
    double reference;      // subtracted from the readings
    double* instants;      // its own sets
    double* readings;
  };
  using Evaluate = void (*)(double, double, moments::Regressors&);
  using AddInstant = void (*)(const moments::Regressors&, double, double, double*);
  template <int H>
  static void add_sample(OpenBlock& block, int channel, std::int64_t t_ns, double value) noexcept;

  [[nodiscard]] Member& member(int c) noexcept { return members_[static_cast<std::size_t>(c)]; }
  [[nodiscard]] const Member& member(int c) const noexcept { return members_[static_cast<std::size_t>(c)]; }
  [[nodiscard]] int channels() const noexcept { return static_cast<int>(members_.size()); }
  // The set that c adds its instants to.
  [[nodiscard]] const double* shared_instants(int c) const noexcept { return member(member(c).leader).instants; }
  void evaluate(std::int64_t t_ns, moments::Regressors& out) const noexcept;
  void settle_members(int leader) noexcept;
  void break_away(int c) noexcept;
  void regroup(const MomentSets& sets) noexcept;
  // Those of c; `scratch` holds them where its group's set has more.
  [[nodiscard]] const double* instants_of(int c, double* scratch) const noexcept;

  int instants_count_;
  std::vector<Member> members_;
  bool open_ = false;
  std::size_t slot_ = 0;
  std::int64_t centre_ns_ = 0, end_ns_ = 0;
  double omega_ = 0.0;
  moments::Regressors now_;
  // The inner loops know H at compile time; these are the right ones for this H.
  Evaluate evaluate_ = nullptr;
  AddInstant add_instant_ = nullptr;
  void (*add_sample_)(OpenBlock&, int, std::int64_t, double) = nullptr;
};

}  // namespace dwell
