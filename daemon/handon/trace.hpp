// One channel over a run, thinned out for a picture.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace dwell::handon {

// The smallest and largest reading in each of kBins equal parts of the time. Bound to one thread. 10 kB.
class Trace {
 public:
  static constexpr std::size_t kBins = 600;  // finer than print at a width of 170 mm
  struct Bin {
    double low, high;
  };

  Trace();
  // x: in the channel's unit. part: of the whole time, 0 … 1.
  void take(double part, double x) noexcept;
  [[nodiscard]] const std::array<Bin, kBins>& bins() const noexcept { return bins_; }  // low > high: no reading
  [[nodiscard]] std::uint64_t count() const noexcept { return count_; }
  [[nodiscard]] double low() const noexcept { return low_; }
  [[nodiscard]] double high() const noexcept { return high_; }

 private:
  std::array<Bin, kBins> bins_;
  std::uint64_t count_ = 0;
  double low_, high_;
};

}  // namespace dwell::handon
