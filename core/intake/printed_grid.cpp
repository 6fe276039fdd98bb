#include "core/intake/printed_grid.hpp"

#include <algorithm>

namespace dwell {

void PrintedGrid::proceed(double size) noexcept {
  switch (state_) {
    case State::collecting:
      sizes_[count_++] = size;
      if (count_ < kDifferences) return;
      std::sort(sizes_.begin(), sizes_.end());
      base_ = 0;
      multiple_ = 0;
      largest_ = 0.0;
      state_ = State::searching;
      return;
    case State::searching:
      search();
      return;
    case State::resting:
      rest_ = std::min(2 * rest_, kRest);
      count_ = 0;
      state_ = State::collecting;
  }
}

void PrintedGrid::search() noexcept {
  for (int tries = 0; tries < kTries; ++tries) {
    const double step = refined(sizes_[base_] / ++multiple_);
    largest_ = std::max(largest_, step);
    if (step == 0.0 && multiple_ < kLargestMultiple) continue;
    multiple_ = 0;
    base_ += kGlitches / 2;
    if (base_ > kGlitches) return take_result(largest_);
  }
}

double PrintedGrid::refined(double step) const noexcept {
  const double least = std::log(kByChance);
  double chance = 0.0;                                        // logarithm of the probability of so good a match
  double products = 0.0, squares = 0.0, farthest = INFINITY;  // farthest: so many steps are still told beyond doubt
  double before = 0.0, off = 0.0;  // the newest multiple matched, and the largest deviation of its differences
  int multiples = 0;               // matched so far; the first made the step, so it proves nothing
  std::size_t glitches = base_, doubtful = 0;
  const auto end_multiple = [&] {
    if (multiples > 1) chance += std::log(std::max(2 * off, 1e-15));
  };
  for (std::size_t i = base_; i < kDifferences; ++i) {
    const double times = sizes_[i] / step, whole = std::round(times);
    if (times > farthest) {  // and so are all after it
      doubtful = kDifferences - i;
      break;
    }
    const double deviation = std::abs(times - whole);
    if (whole < 1 || deviation > kOff) {
      if (++glitches > kGlitches) return 0.0;
      continue;
    }
    if (whole != before) {
      end_multiple();
      ++multiples;
      before = whole;
      off = 0.0;
    }
    off = std::max(off, deviation);
    products += sizes_[i] * whole;
    squares += whole * whole;
    step = products / squares;
    farthest = whole / (4 * kOff);
  }
  end_multiple();
  if (glitches > 0)  // there are at most (64e/g)^g ways to choose g of 64
    chance += static_cast<double>(glitches) *
              (1 + std::log(static_cast<double>(kDifferences) / static_cast<double>(glitches)));
  return chance < least && 4 * doubtful < kDifferences ? step : 0.0;
}

// A step that was found is given up for another result once that comes twice in a row.
void PrintedGrid::take_result(double step) noexcept {
  const bool again = std::abs(step - newest_) <= kSame * step;
  if (step_ == 0.0 || again) step_ = step;
  newest_ = step;
  rested_ = 0;
  state_ = State::resting;
}

}  // namespace dwell
