// Looks for errors of the readings that grow with the motion, channel by channel, while a dwell's data count.
//
// It looks at the newest readings: first after twelve periods, then each time the data have become twice as long, and
// at the dwell's end. So the cost is a constant number of readings each time. While the dwell goes on, a look is spread
// over several calls; at its end it is done at once. What is found holds for the rest of the dwell.
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
  // Whether go_on() has work: a look is not finished, or the next is due. period_s: of the drive.
  [[nodiscard]] bool due(std::int64_t now_ns, double period_s) const noexcept;

  // What a look needs to know of a channel.
  struct About {
    MovingContext context;
    double known_s = 0.0;  // standard deviation of its instants that the budget has already
  };
  // A look takes one reading in so many, about fifty a period. interval_s: between a channel's readings.
  [[nodiscard]] static int every(double interval_s, double period_s) noexcept {
    return std::max(1, static_cast<int>(period_s / (kInPeriod * std::max(interval_s, 1e-9))));
  }
  // Goes on with a look at the readings in [from_ns, until_ns), or begins it. ask.every(c): see every().
  // ask.transient(c, t_ns): what of the reading is known to be transient, SI. ask.about(c, about_ns): its fit's phases
  // about about_ns. O(samples held) to begin, then some 16 000 readings a call.
  template <class Ask>
  void go_on(const SampleHistory& history, std::int64_t from_ns, std::int64_t until_ns, Ask& ask) noexcept {
    if (next_ == seen_.size()) gather(history, from_ns, until_ns, ask);
    for (std::size_t judged = 0; next_ < seen_.size() && judged < kAtOnce; judged += counts_[next_++])
      judge(static_cast<int>(next_), ask);
    if (next_ == seen_.size()) keep();
  }
  // A whole look.
  template <class Ask>
  void look(const SampleHistory& history, std::int64_t from_ns, std::int64_t until_ns, Ask& ask) noexcept {
    next_ = seen_.size();
    do go_on(history, from_ns, until_ns, ask);
    while (next_ < seen_.size());
  }

  // Standard deviation of the channel's gain from reading to reading, relative; 0: nothing was found.
  [[nodiscard]] double part(int channel) const noexcept { return found(channel).part; }
  // Standard deviations of its instants, s: by errors of its own, and by errors that its group shares. Channels with
  // the same with() are a group and have the same shared_s(); -1: no group.
  [[nodiscard]] double own_s(int channel) const noexcept { return found(channel).own_s; }
  [[nodiscard]] double shared_s(int channel) const noexcept { return found(channel).shared_s; }
  [[nodiscard]] int with(int channel) const noexcept { return found(channel).with; }

 private:
  struct Found {
    double part = 0.0, own_s = 0.0, shared_s = 0.0;
    int with = -1;
  };
  static constexpr double kInPeriod = 50.0;       // readings
  static constexpr std::size_t kAtOnce = 16'384;  // readings judged in one call: a quarter of a look

  [[nodiscard]] const Found& found(int channel) const noexcept { return found_[static_cast<std::size_t>(channel)]; }
  [[nodiscard]] std::span<MovingReading> of_channel(std::size_t c) noexcept {
    return std::span(readings_).subspan((c + 1) * most_ - counts_[c], counts_[c]);
  }
  // The newest readings of each channel, from the end of its room on downwards.
  template <class Ask>
  void gather(const SampleHistory& history, std::int64_t from_ns, std::int64_t until_ns, Ask& ask) noexcept {
    looked_ns_ = until_ns;
    next_ = 0;
    std::fill(counts_.begin(), counts_.end(), std::size_t{0});
    std::fill(passed_.begin(), passed_.end(), 0);
    std::size_t full = 0;
    const std::uint64_t first = history.first_at(from_ns);
    for (std::uint64_t number = history.first_at(until_ns); number > first && full < counts_.size();) {
      const SampleHistory::Sample& sample = history[--number];
      const auto c = static_cast<std::size_t>(sample.channel);
      if (sample.held_up || counts_[c] == most_ || passed_[c]++ % ask.every(sample.channel) != 0) continue;
      readings_[(c + 1) * most_ - ++counts_[c]] = {.t_ns = sample.t_ns, .value = sample.value};
      full += counts_[c] == most_ ? 1 : 0;
    }
  }
  template <class Ask>
  void judge(int channel, Ask& ask) noexcept {
    const auto c = static_cast<std::size_t>(channel);
    const std::span<MovingReading> readings = of_channel(c);
    seen_[c] = MovingChannel{};
    seen_[c].readings = readings;
    if (readings.empty()) return;
    for (MovingReading& reading : readings) reading.value -= ask.transient(channel, reading.t_ns);
    const std::int64_t first_ns = readings.front().t_ns;
    const About about = ask.about(channel, first_ns + (readings.back().t_ns - first_ns) / 2);
    omega_ = about.context.omega;
    seen_[c].amplitude = std::abs(about.context.fit.X[0]);
    seen_[c].known_s = about.known_s;
    seen_[c].errors = moving_errors(readings, about.context);
  }
  // Takes what is seen into what is found.
  void keep() noexcept;
  // Makes the channel's group that of `lead`, with these errors at least.
  void join(std::size_t lead, std::size_t channel, double shared_s) noexcept;

  std::size_t most_;                     // readings of a channel
  std::vector<MovingReading> readings_;  // most_ for each channel
  std::vector<std::size_t> counts_;
  std::vector<int> passed_;
  std::vector<MovingChannel> seen_;
  std::vector<Found> found_;
  std::vector<bool> grouped_;  // at this look
  std::size_t next_;           // channel that the look has come to; all: no look is on
  double omega_ = 0.0;         // at the last look, rad/s
  std::int64_t settled_ns_ = 0, looked_ns_ = 0;
};

}  // namespace dwell
