// How many readings of a hold were left out before the motion gate saw them, and whether what was left out says
// something of the device.
#pragma once

#include <cmath>
#include <cstdint>

namespace dwell {

// Of one channel. Bound to one thread; real-time safe.
class LeftOut {
 public:
  void beyond_range(bool code) noexcept {
    ++of_all_time_;
    ++overrange_;
    if (code) ++codes_;
  }
  void spike() noexcept {
    ++of_all_time_;
    ++spikes_;
  }
  void repeat() noexcept {
    ++of_all_time_;
    ++repeats_;
  }
  // The motion gate leaves out a reading that is far from all others.
  void far_spike() noexcept { far_spike_ = true; }

  [[nodiscard]] std::uint64_t overrange() const noexcept { return overrange_; }
  [[nodiscard]] std::uint64_t codes() const noexcept { return codes_; }
  [[nodiscard]] std::uint64_t spikes() const noexcept { return spikes_; }
  [[nodiscard]] std::uint64_t repeats() const noexcept { return repeats_; }
  [[nodiscard]] std::uint64_t of_all_time() const noexcept { return of_all_time_; }

  // Far spikes, numbers beyond the range, or more than the gate takes of good readings. readings: of this hold;
  // foreign: what the motion gate left out of them; held: repeats are refreshes that did not come.
  [[nodiscard]] bool matters(std::uint64_t readings, std::uint64_t foreign, bool held) const noexcept {
    if (overrange_ > 0 || spikes_ > before_.spikes || far_spike_) return true;
    const std::uint64_t left = foreign + (held ? 0 : repeats_);
    return static_cast<double>(left) - static_cast<double>(before_.left) >
           kUnsaid * std::sqrt(static_cast<double>(readings - before_.readings));
  }

  void begin_hold() noexcept { overrange_ = codes_ = spikes_ = repeats_ = 0; }
  void begin_to_count(std::uint64_t readings, std::uint64_t foreign) noexcept {
    before_ = {readings, spikes_, foreign + repeats_};
    far_spike_ = false;
  }

 private:
  // The gate now and then leaves out good readings while a transient is large. It says nothing of up to kUnsaid √N of N
  // readings. If all lie 8 σ off on one side, k of them move a phasor by 16 k σ/N. With u = σ √(2/N) that is 0.57 u at
  // this limit. Chosen on 400 healthy dwells of the study: none blames a channel. Other values were not tried.
  static constexpr double kUnsaid = 0.05;
  std::uint64_t overrange_ = 0, codes_ = 0, spikes_ = 0, repeats_ = 0;  // of this hold
  std::uint64_t of_all_time_ = 0;
  bool far_spike_ = false;
  struct {
    std::uint64_t readings = 0, spikes = 0, left = 0;
  } before_;  // the data counted, in this hold
};

}  // namespace dwell
