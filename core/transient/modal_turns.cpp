#include "core/transient/modal_turns.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/complex.hpp"
#include "core/base/instants.hpp"

namespace dwell {
namespace {

constexpr double kFaded = 1e-13;   // an envelope below this counts as 0
constexpr int kTurnsInARow = 256;  // steps until a direct computation: rounding stays below 1e-13

}  // namespace

void ModalTurns::restart() noexcept {
  at_ns_ = INT64_MIN;
  for (Step& step : steps_) step.dt_ns = 0;
}

void ModalTurns::go(const ModalMotion& motion, std::int64_t t_ns) noexcept {
  if (t_ns > at_ns_ && at_ns_ >= motion.t0_ns() && taken_ < kTurnsInARow)
    turn_by(motion, t_ns - at_ns_);
  else
    turn_to(motion, t_ns);
  if (motion.rate() != 0) drive_ = std::polar(1.0, motion.angle(t_ns));
  at_ns_ = t_ns;
}

void ModalTurns::turn_to(const ModalMotion& motion, std::int64_t t_ns) noexcept {
  const double u = motion.seconds(t_ns);
  drive_ = std::polar(1.0, motion.omega() * u);
  for (std::size_t m = 0; m < motion.count(); ++m) {
    const Complex pole = motion.poles()[m];
    const double envelope = std::exp(pole.real() * u);
    modes_[m] = envelope < kFaded ? Complex{} : std::polar(envelope, pole.imag() * u);
  }
  taken_ = 0;
}

void ModalTurns::turn_by(const ModalMotion& motion, std::int64_t dt_ns) noexcept {
  auto step = std::find_if(steps_.begin(), steps_.end(), [&](const Step& each) { return each.dt_ns == dt_ns; });
  if (step == steps_.end()) {
    step = steps_.begin() + static_cast<std::ptrdiff_t>(next_step_++ % steps_.size());
    const double dt_s = to_s(dt_ns);
    step->dt_ns = dt_ns;
    step->drive = std::polar(1.0, motion.omega() * dt_s);
    for (std::size_t m = 0; m < motion.count(); ++m) {
      const Complex pole = motion.poles()[m];
      step->modes[m] = std::polar(std::exp(pole.real() * dt_s), pole.imag() * dt_s);
    }
  }
  // Written out: the product of std::complex checks for infinities, which costs time.
  const auto times = [](Complex a, Complex b) {
    return Complex{a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
  };
  drive_ = times(drive_, step->drive);
  for (std::size_t m = 0; m < motion.count(); ++m) {
    if (modes_[m] == Complex{}) continue;
    modes_[m] = times(modes_[m], step->modes[m]);
    if (std::norm(modes_[m]) < kFaded * kFaded) modes_[m] = {};
  }
  ++taken_;
}

}  // namespace dwell
