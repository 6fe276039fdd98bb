// The sums of the modal fit in all channels. Channels that are read at the same instants have the same regressors, and
// so one normal matrix.
//
// All channels begin as one group. A group keeps one matrix as long as every scan brings a sample of each of its
// channels. Those that miss a scan leave it: they take the matrix as it was before that scan, and are a group of their
// own. So the sums are those of each channel by itself, bit for bit. Channels with instants of their own soon have a
// matrix each.
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
  // most: regressors at most.
  SharedSums(int channels, Eigen::Index most);

  void clear() noexcept;
  // A sample: its first `all` regressors, as many for each until clear(). scan: above 0; samples that follow one
  // another with the same number have the same regressors, and a channel has one of them. O(all²) for the first sample
  // of a scan in each group, else O(all): the multiplications are returned.
  double add(int channel, std::uint64_t scan, const Eigen::VectorXd& x, Eigen::Index all, double value) noexcept;
  // To be called before the normal matrix of a channel is read.
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
    int seen = 0;            // of them, with a sample of the newest scan
    std::uint64_t scan = 0;  // the newest; 0: there is none
  };
  [[nodiscard]] const PerChannel& at(int channel) const noexcept {
    return channels_[static_cast<std::size_t>(channel)];
  }
  void part(std::size_t group, Eigen::Index all) noexcept;

  std::vector<PerChannel> channels_;
  std::vector<Group> groups_;
  std::size_t used_ = 1;  // groups
};

}  // namespace dwell
