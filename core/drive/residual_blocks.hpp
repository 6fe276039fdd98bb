// Sums the residuals of the table's channel, against the prediction by its reference, over quarters of a period.
//
// With m the predicted fundamental, q its quadrature and r a reading's residual, a quarter's sums of r m, m², r q and
// q² tell by how much amplitude and phase differ from the reference. Sums over several quarters tell since when.
//
// All memory is allocated by the constructor. Bound to one thread; real-time safe.
#pragma once

#include <algorithm>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace dwell {

struct ResidualBlock {
  double t_s = 0.0;  // mean instant of its readings, from the reference's
  double rm = 0.0, mm = 0.0, rq = 0.0, qq = 0.0;
  double extra_u2 = 0.0, n = 0.0;  // sum of extra_u_s², s²; number of readings
};

// Sums over the blocks since an instant. Moments of time are about now: an older block extends the sums to its begin.
struct ResidualsSince {
  double extra_u2 = 0, n = 0, rm = 0, mm = 0, q0 = 0, q1 = 0, q2 = 0, r0 = 0, r1 = 0;
  void take(const ResidualBlock& block, double ago_s) noexcept {
    extra_u2 += block.extra_u2;
    n += block.n;
    rm += block.rm;
    mm += block.mm;
    r0 += block.rq;
    r1 += block.rq * ago_s;
    q0 += block.qq;
    q1 += block.qq * ago_s;
    q2 += block.qq * ago_s * ago_s;
  }
  // Σ r q τ and Σ q² τ²; τ is the time since the instant, which was since_s ago.
  [[nodiscard]] double score(double since_s) const noexcept { return since_s * r0 - r1; }
  [[nodiscard]] double weight(double since_s) const noexcept { return since_s * since_s * q0 - 2 * since_s * q1 + q2; }
};

class ResidualBlocks {
 public:
  static constexpr int kLongest = 512;  // blocks kept

  ResidualBlocks() : blocks_(kLongest) {}

  void restart() noexcept {
    seen_ = 0;
    in_quarter_ = 0.0;
    drop_open();
  }
  // Takes a reading at t_s: residual r, predicted m (imaginary part) and q (real part); extra_u_s: as in
  // StepWatch::add().
  void add(double t_s, double r, std::complex<double> predicted, double extra_u_s) noexcept {
    open_.rm += r * predicted.imag();
    open_.mm += predicted.imag() * predicted.imag();
    open_.rq += r * predicted.real();
    open_.qq += predicted.real() * predicted.real();
    open_.extra_u2 += extra_u_s * extra_u_s;
    open_.n += 1.0;
    open_t_ += t_s;
  }
  // Ends a quarter and keeps it as a block. False: it has no readings and makes no block.
  bool close() noexcept {
    if (open_.n == 0) return false;
    open_.t_s = open_t_ / open_.n;
    in_quarter_ += ((seen_ == 0 ? open_.n : std::min(open_.n, 2 * in_quarter_)) - in_quarter_) / (seen_ < 8 ? 2 : 8);
    blocks_[static_cast<std::size_t>(seen_) % kLongest] = open_;
    ++seen_;
    drop_open();
    return true;
  }
  // Forgets the readings since the last close().
  void drop_open() noexcept {
    open_ = {};
    open_t_ = 0.0;
  }

  // Blocks so far; blocks kept; the k-th block before the newest; readings in a usual block.
  [[nodiscard]] std::int64_t seen() const noexcept { return seen_; }
  [[nodiscard]] int kept() const noexcept { return static_cast<int>(std::min<std::int64_t>(seen_, kLongest)); }
  [[nodiscard]] const ResidualBlock& back(int k) const noexcept {
    return blocks_[static_cast<std::size_t>(seen_ - 1 - k) % kLongest];
  }
  [[nodiscard]] ResidualBlock& back(int k) noexcept {
    return blocks_[static_cast<std::size_t>(seen_ - 1 - k) % kLongest];
  }
  [[nodiscard]] double in_quarter() const noexcept { return in_quarter_; }

 private:
  std::vector<ResidualBlock> blocks_;
  ResidualBlock open_;
  double open_t_ = 0.0, in_quarter_ = 0.0;
  std::int64_t seen_ = 0;
};

}  // namespace dwell
