// A stream as the estimation hands it out, in virtual time: ticks every 10 ms, samples of some channels, and the
// records that bracket runs.
#pragma once

#include <cstdint>
#include <functional>
#include <random>

#include "core/stream/record.hpp"

namespace dwell::record {

class SyntheticStream {
 public:
  SyntheticStream(int channels, double rate_hz, std::function<void(const Record&)> to)
      : channels_(channels), period_ns_(static_cast<std::int64_t>(1e9 / rate_hz)), to_(std::move(to)) {}

  // On to `seconds` after now.
  void play(double seconds) {
    const std::int64_t until_ns = t_ns_ + static_cast<std::int64_t>(seconds * 1e9);
    while (t_ns_ < until_ns) {
      t_ns_ += period_ns_;
      if (t_ns_ >= next_tick_ns_) {
        put({.t_ns = next_tick_ns_, .kind = Kind::tick});
        next_tick_ns_ += 10'000'000;
      }
      // A scan: all channels at one instant, signed 16-bit numbers with noise.
      for (int channel = 0; channel < channels_; ++channel) {
        const double value = 1000.0 * channel + static_cast<double>(random_() % 64);
        put({.t_ns = t_ns_,
             .stamped_ns = t_ns_,
             .value = value,
             .t_half_ns = 1000,
             .channel = static_cast<std::uint16_t>(channel)});
      }
    }
  }
  void armed() {
    put({.t_ns = t_ns_, .kind = Kind::run, .flags = static_cast<std::uint8_t>(RunEdge::armed)});
    elder_ = younger_;
    younger_ = number_;
  }
  // The elder of the two pipelines sees the drive, or the only one.
  void begins(std::uint16_t request = 0) {
    born_ = elder_ != 0 ? elder_ : younger_;
    put({.t_ns = t_ns_,
         .value = static_cast<double>(number_ + 1 - born_),
         .channel = request,
         .kind = Kind::run,
         .flags = static_cast<std::uint8_t>(RunEdge::begins)});
  }
  // A run with nothing before it.
  void starts() {
    armed();
    begins();
  }
  void ends(EndOfRun why = EndOfRun::drive_stopped, std::uint16_t request = 0) {
    put({.t_ns = t_ns_,
         .value = static_cast<double>(why),
         .channel = request,
         .kind = Kind::run,
         .flags = static_cast<std::uint8_t>(RunEdge::ends)});
    elder_ = younger_ = 0;
  }
  void put(const Record& record) {
    ++number_;
    to_(record);
  }

  [[nodiscard]] std::int64_t t_ns() const noexcept { return t_ns_; }
  // Of the record that came last, in the run that began last.
  [[nodiscard]] std::uint64_t position() const noexcept { return number_ + 1 - born_; }

 private:
  int channels_;
  std::int64_t period_ns_;
  std::function<void(const Record&)> to_;
  std::mt19937 random_{7};
  std::int64_t t_ns_ = 1'000'000'000, next_tick_ns_ = 1'000'000'000;
  std::uint64_t number_ = 0, elder_ = 0, younger_ = 0, born_ = 1;
};

}  // namespace dwell::record
