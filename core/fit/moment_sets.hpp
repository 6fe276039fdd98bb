// Holds the moments of all channels in a fixed number of slots, one slot for each block of a dwell.
//
// A slot has two sets per channel: the moments of its instants and those of its readings. Channels that were read at
// the same instants share one set of instants, that of their owner.
//
// All memory is allocated by the constructor. Bound to one thread; real-time safe.
#pragma once

#include <cstddef>
#include <vector>

#include "core/fit/moments.hpp"

namespace dwell {

class MomentSets {
 public:
  MomentSets(std::size_t slots, int channels, int harmonics);

  [[nodiscard]] int channels() const noexcept { return channels_; }
  // Angles in a set of instants, 2H+1.
  [[nodiscard]] int instants_count() const noexcept { return instants_count_; }

  // A channel's own sets in a slot: of the instants (2H+1 angles), of the readings (H+1 angles).
  [[nodiscard]] double* instants(std::size_t slot, int c) noexcept {
    return &instants_[at(slot, c) * moments::size(instants_count_)];
  }
  [[nodiscard]] double* readings(std::size_t slot, int c) noexcept {
    return &readings_[at(slot, c) * moments::size(readings_count_)];
  }
  [[nodiscard]] const double* readings(std::size_t slot, int c) const noexcept {
    return &readings_[at(slot, c) * moments::size(readings_count_)];
  }
  // Channel whose set of instants c shares; c itself: it has its own.
  [[nodiscard]] int owner(std::size_t slot, int c) const noexcept { return owners_[at(slot, c)]; }
  void share(std::size_t slot, int c, int owner) noexcept { owners_[at(slot, c)] = owner; }
  // The set of instants valid for a channel: its owner's.
  [[nodiscard]] const double* shared_instants(std::size_t slot, int c) const noexcept {
    return &instants_[at(slot, owner(slot, c)) * moments::size(instants_count_)];
  }

  // Empties the readings of a slot, and makes each channel the owner of its instants. The sets of instants keep their
  // old numbers: clear_instants() must follow for each channel that owns its set.
  void clear(std::size_t slot) noexcept;
  // Empties a channel's own set of instants. A channel that shares another one's set needs no call.
  void clear_instants(std::size_t slot, int c) noexcept;
  // Makes slot `into` the sum of two others, each turned to the frequency and centre of `into`. Channels with the same
  // owner in both keep that owner. O(channels · H).
  struct Part {
    std::size_t slot;
    moments::Turn turn;
  };
  void join(const Part& older, const Part& newer, std::size_t into) noexcept;

 private:
  [[nodiscard]] std::size_t at(std::size_t slot, int c) const noexcept {
    return slot * static_cast<std::size_t>(channels_) + static_cast<std::size_t>(c);
  }

  int channels_, instants_count_, readings_count_;
  std::vector<double> instants_, readings_;
  std::vector<int> owners_;
};

}  // namespace dwell
