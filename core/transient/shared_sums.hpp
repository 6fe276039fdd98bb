// Keeps the sums of the modal fit in all channels. Channels that are read at the same instants have the same regressors
// and share one normal matrix.
//
// All channels begin as one group. A group shares one matrix while every scan brings a sample of each of its channels.
// Channels that miss a scan form a new group, with the matrix as it was before that scan. The sums are therefore those
// of each channel by itself, bit for bit. Channels with instants of their own soon have a matrix each.
//
// All memory is allocated by the constructor. Bound to one thread; real-time safe.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/transient/modal_sums.hpp"
#include "core/transient/normal_matrix.hpp"

namespace dwell {

class SharedSums {
 public:
  // most: capacity in regressors.
  SharedSums(int channels, Eigen::Index most);

  void clear() noexcept;
  // Adds a sample by the first `all` elements of x; `all` stays the same until clear(). scan: above 0. Consecutive
  // samples of one scan have the same regressors; a channel has one sample in each. Returns the number of
  // multiplications: O(all²) for the first sample of a scan in each group, else O(all).
  double add(int channel, std::uint64_t scan, const Eigen::VectorXd& x, Eigen::Index all, double value) noexcept;
  // Call before the normal matrix of a channel is read.
  void complete(int channel, Eigen::Index all) noexcept;

  [[nodiscard]] ModalSums of(int channel) const noexcept {
    const PerChannel& own = at(channel);
    return {groups_[own.group].normal.sum(), own.readings};
  }
  [[nodiscard]] double samples(int channel) const noexcept { return at(channel).readings.samples; }
  [[nodiscard]] double reference(int channel) const noexcept { return at(channel).readings.reference; }
  // Channels of one group have the same normal matrix.
  [[nodiscard]] std::size_t group(int channel) const noexcept { return at(channel).group; }

 private:
  struct PerChannel {
    ReadingSums readings;
    std::size_t group = 0;
    std::uint64_t scan = 0;  // of its newest sample
  };
  struct Group {
    NormalMatrix normal;
    int members = 0;
    int seen = 0;            // members with a sample in the newest scan
    std::uint64_t scan = 0;  // the newest; 0: none yet
  };
  [[nodiscard]] const PerChannel& at(int channel) const noexcept {
    return channels_[static_cast<std::size_t>(channel)];
  }
  void part(std::size_t group, Eigen::Index all) noexcept;

  std::vector<PerChannel> channels_;
  std::vector<Group> groups_;
  std::size_t used_ = 1;  // number of groups in use
};

}  // namespace dwell
