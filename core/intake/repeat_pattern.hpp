// Tells a register that is refreshed more slowly than it is read from a gateway that repeats its last answer at random.
// Both show runs of identical readings amid a motion. Two things differ: the distances from one repeat to the next
// (repeat_distances.hpp), and the jump after a repeat (repeat_catch_up.hpp).
//
// Repeats are random only if distances and jumps both say so, since jittering instants alone make distances irregular.
// If a register were taken for random repeats, its channel would be late by half a refresh interval, and nothing would
// say so.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/chance.hpp"
#include "core/intake/repeat_catch_up.hpp"
#include "core/intake/repeat_distances.hpp"

namespace dwell {

// Judges the repeats of one channel. Bound to one thread; real-time safe. O(1) per call.
class RepeatPattern {
 public:
  // Counts further readings.
  void pass(std::size_t readings) noexcept { distances_.pass(readings); }
  // A run of identical readings has ended. The jumps before and after it are larger than chance. run: its length,
  // readings. few: identical readings are so few that a register would never repeat a reading three times.
  void repeat(std::int64_t run, bool few) noexcept { distances_.repeat(few && run > kLongest); }
  // How the motion went on: see RepeatCatchUp::add().
  void caught(std::int64_t run, double before, double after, double next, double mean) noexcept {
    catch_up_.add(run, before, after, next, mean);
  }

  // Whether the repeats come at a constant rate of refresh. If the jumps speak against it, more proof is needed.
  [[nodiscard]] bool regular() const noexcept {
    return distances_.proof() >= (catch_up_.shown() ? nats::kOneIn1e6 : nats::kOneIn1000);
  }
  // Whether they come at random.
  [[nodiscard]] bool random() const noexcept { return distances_.irregular() && catch_up_.shown(); }
  // Whether they may turn out to be random once more jumps are known.
  [[nodiscard]] bool may_be_random() const noexcept { return distances_.proof() < 0.0 && catch_up_.possible(); }
  // Whether at most one distance speaks against a register, and the jumps do not.
  [[nodiscard]] bool may_be_regular() const noexcept {
    return distances_.proof() >= RepeatDistances::kIrregular - 0.2 && !catch_up_.shown();
  }

 private:
  static constexpr std::int64_t kLongest = 3;  // run of a register that seldom repeats one

  RepeatDistances distances_;
  RepeatCatchUp catch_up_;
};

}  // namespace dwell
