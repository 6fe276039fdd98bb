// Finds the rounding step of a device: all differences of its readings are multiples of it.
//
// Euclid's algorithm, one step per difference, reaches it within some twenty differences. kSure multiples in a row end
// a batch. One reading off the grid spoils only its batch: the batches vote, and the step changes only if more of them
// contradict it than agree. Where the readings were rounded once more, much more finely, Euclid's algorithm finds that
// second step. PrintedGrid finds the coarse one, which counts.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/intake/printed_grid.hpp"

namespace dwell {

// Of one channel, in any unit. Bound to one thread; real-time safe; a division a difference, and now and then a search
// (PrintedGrid).
class RoundingStep {
 public:
  // The difference of two consecutive good readings.
  void add(double difference) noexcept {
    difference = std::abs(difference);
    if (!(difference > 0) || !std::isfinite(difference)) return;
    printed_.add(difference);
    const double before = batch_;
    batch_ = common(batch_, difference);
    in_row_ = (in_row_ + 1) * static_cast<int>(batch_ == before);
    if (in_row_ < kSure) return;
    vote(batch_);
    batch_ = INFINITY;
    in_row_ = 0;
  }

  // INFINITY: no two readings have differed; 0: there is no step.
  [[nodiscard]] double step() const noexcept {
    const double exact = std::isfinite(step_) ? step_ : batch_;
    return printed_.step() > kCoarser * exact ? printed_.step() : exact;
  }

 private:
  // kOnGrid: deviation from a multiple, in steps. A grid finer than the differences by kNoGrid is none: Euclid's
  // algorithm on arbitrary numbers ends at 0.
  static constexpr double kOnGrid = 0.01, kNoGrid = 1e9;
  // Multiples in a row. A batch ends at a multiple of the true step once in 2^8, arbitrary numbers at a grid once in
  // 10^13. With twice as many, one reading in 30 off the grid would spoil every batch.
  static constexpr int kSure = 8;
  static constexpr double kMultiple = 8.0;  // steps: a batch with a larger divisor contradicts the step
  static constexpr double kCoarser = 1.5;   // PrintedGrid's step is another one only if it is so many times coarser
  static constexpr int kMemory = 16;        // batches that vote: a device set to another range is followed

  static double common(double step, double difference) noexcept {
    if (step == 0) return 0.0;  // of arbitrary numbers
    if (!std::isfinite(step)) return difference;
    const double times = difference / step;
    if (!(times < kNoGrid)) return 0.0;
    if (times < 0.5) return difference;  // only zero is a multiple near it, and the readings differ
    const double above = times + 0.5;    // truncated it equals std::round(times), without a call
    const double off = std::abs(difference - step * static_cast<double>(static_cast<std::int64_t>(above)));
    return off > kOnGrid * step ? off : step;
  }
  [[nodiscard]] bool agrees(double divisor) const noexcept {
    if (step_ == 0 || divisor == 0) return step_ == divisor;
    const double times = divisor / step_, whole = std::round(times);
    return whole >= 1 && whole <= kMultiple && std::abs(times - whole) < kOnGrid * whole;
  }
  void vote(double divisor) noexcept {
    if (!std::isfinite(step_)) step_ = divisor;
    agrees(divisor) ? ++for_ : ++against_;
    if (against_ > for_) {
      const double finer = common(step_, divisor);
      step_ = finer * kMultiple > divisor ? finer : divisor;
      for_ = 1;
      against_ = 0;
    } else if (for_ + against_ > kMemory) {
      for_ /= 2;
      against_ /= 2;
    }
  }

  PrintedGrid printed_;
  double step_ = INFINITY, batch_ = INFINITY;
  int in_row_ = 0, for_ = 0, against_ = 0;
};

}  // namespace dwell
