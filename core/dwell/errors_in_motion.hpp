// Looks for errors of the readings that grow with the motion, channel by channel, while a dwell's data count.
//
// It looks at the newest readings: first after twelve periods, then each time the data have become twice as long, and
// at the dwell's end. So a sample's cost does not grow with the dwell. A look takes some channels at a time, so that no
// turn is long. What was found once holds for the whole dwell, whose data it is in.
#pragma once

#include <algorithm>
#include <complex>
#include <cstdint>
#include <span>
#include <vector>

#include "core/fit/moving_errors.hpp"
#include "core/stream/sample_history.hpp"

namespace dwell {

// Bound to one thread; real-time safe but for the constructor.
class ErrorsInMotion {
 public:
  explicit ErrorsInMotion(int channels);

  // The data count from settled_ns on. Nothing is found yet.
  void begin(std::int64_t settled_ns) noexcept;
  // Whether a look is on, or data up to now_ns are to be looked at. period_s: of the drive.
  [[nodiscard]] bool due(std::int64_t now_ns, double period_s) const noexcept;
  // Begins a look at the newest readings before until_ns, unless one is on, and goes on with it. context(c, about_ns):
  // of channel c, its fit's phases about about_ns. At most 65 536 readings are gathered, and some 16 000 of them judged
  // in one call, 50 ns each.
  template <class Context>
  void go_on(const SampleHistory& history, std::int64_t until_ns, const Context& context) noexcept {
    if (next_ == seen_.size()) begin_look(history, until_ns);
    for (std::size_t judged = 0; next_ < seen_.size() && judged < kAtOnce; judged += counts_[next_++]) {
      const MovingContext of = context(static_cast<int>(next_), about_ns_);
      seen_[next_] = {of_channel(next_), std::abs(of.fit.X[0]), moving_errors(of_channel(next_), of)};
      omega_ = of.omega;
    }
    if (next_ == seen_.size()) keep();
  }
  // A whole look at the newest readings before until_ns.
  template <class Context>
  void look(const SampleHistory& history, std::int64_t until_ns, const Context& context) noexcept {
    next_ = seen_.size();
    do go_on(history, until_ns, context);
    while (next_ < seen_.size());
  }

  // Standard deviations of what was found. part: errors of the channel's readings, as a part of themselves.
  [[nodiscard]] double part(int channel) const noexcept { return found(channel).part; }
  // Of instants, s: of this channel's own, and of those that it shares with others, which have the same `with`; -1:
  // with none. What they share is the same number for all of them.
  [[nodiscard]] double own_s(int channel) const noexcept {
    return found(channel).with == channel ? 0.0 : found(channel).instants_s;
  }
  [[nodiscard]] double shared_s(int channel) const noexcept {
    return with(channel) < 0 ? 0.0 : found(with(channel)).instants_s;
  }
  [[nodiscard]] int with(int channel) const noexcept { return found(channel).with; }

 private:
  struct Found {
    double part = 0.0;
    double instants_s = 0.0;  // own; of the channel `with`: what all of these share
    int with = -1;
  };
  [[nodiscard]] const Found& found(int channel) const noexcept { return found_[static_cast<std::size_t>(channel)]; }
  static constexpr std::size_t kAtOnce = 16'384;  // readings judged in one call: a millisecond

  // Sorts the newest readings by channel.
  void begin_look(const SampleHistory& history, std::int64_t until_ns) noexcept;
  [[nodiscard]] std::span<MovingReading> of_channel(std::size_t c) noexcept {
    return std::span(readings_).subspan(c * most_, counts_[c]);
  }
  // Takes what is seen into what is found.
  void keep() noexcept;

  std::size_t most_;                     // readings of a channel
  std::vector<MovingReading> readings_;  // most_ for each channel
  std::vector<std::size_t> counts_;
  std::vector<MovingChannel> seen_;
  std::vector<Found> found_;
  std::vector<bool> grouped_;  // at this look: with a channel before
  std::size_t next_;           // channel that the look has come to; all: no look is on
  double omega_ = 0.0;         // at the last look, rad/s
  std::int64_t settled_ns_ = 0, looked_ns_ = 0, about_ns_ = 0;
};

}  // namespace dwell
