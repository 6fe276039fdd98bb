// Gathers the records of the stream as readings of a motion: in SI, at the instants of the motion (each stamp less its
// channel's stated delay), without those that are no numbers or beyond the range of their channel.
//
// An estimate takes a bounded number of readings, from the start of the motion on. The table's activity is judged over
// the whole recording, by the smallest and largest reading of each half period. So a long recording is kept whole only
// around the start of the motion. Elsewhere only those readings of the table are kept. The estimate is the same, to the
// last bit, unless the table's noise alone is above Excitation::minimum.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/intake/device_numbers.hpp"
#include "core/motion/likelihood.hpp"
#include "core/stream/record.hpp"

namespace dwell {

class MotionRecorder {
 public:
  // Most readings kept whole: 125 s of eight channels at 1 kHz, 32 MB. An estimate of a single mass takes 250 000 of
  // them. Halved, a slow start of the motion leaves fewer for it. Doubled, an estimate takes twice the memory.
  static constexpr std::size_t kWhole = 1'000'000;
  // Most half periods of the table kept outside of that part: three hours at 5 Hz, 10 MB. Later ones are not kept.
  // Doubled: twice the memory. Halved: the activity of a long recording is known for half the time.
  static constexpr std::size_t kBlocks = 100'000;

  explicit MotionRecorder(const Rig& rig, std::size_t whole = kWhole);

  // Takes any record, and passes over all but samples of channels that count. Records come in the order of the stream.
  // Allocates now and then.
  void take(const Record& record);
  [[nodiscard]] std::size_t size() const noexcept { return whole_.size(); }  // kept whole
  // By time.
  [[nodiscard]] MotionData data() const;

 private:
  struct Line {
    DeviceNumbers numbers;
    std::int64_t delay_ns;
    bool counts;
  };
  // The first, smallest and largest reading of each half period.
  class Outline {
   public:
    // Adds a reading, SI. Returns whether it begins a new half period.
    bool take(const MotionReading& reading, std::int64_t half_period_ns);
    // Goes on with the half period of `other`, without its readings.
    void follow(const Outline& other);
    void add_to(std::vector<MotionReading>& out) const;
    [[nodiscard]] double amplitude() const noexcept { return empty_ ? 0.0 : 0.5 * (high_.value - low_.value); }

   private:
    bool open_ = false, empty_ = true;
    std::int64_t from_ns_ = 0;
    MotionReading first_, low_, high_;
  };

  void make_room(std::int64_t now_ns);
  void outline(Outline& of, const MotionReading& reading);

  const std::size_t most_;
  std::vector<Line> lines_;
  int table_ = -1;  // the channel by which the table's activity is judged; -1: none
  std::int64_t half_period_ns_ = 0, before_ns_ = 0, least_delay_ns_ = 0, most_delay_ns_ = 0;
  double still_ = 0.0;  // SI of that channel: a smaller amplitude is no motion, whatever the noise is
  bool moved_ = false, full_ = false;
  Outline now_, front_, tail_;  // of all readings until full_, of those before the whole part, of those after it
  std::vector<MotionReading> whole_, outlined_;
  std::int64_t whole_from_ns_ = INT64_MIN, whole_to_ns_ = INT64_MAX;
};

}  // namespace dwell
