// z(t + dt) = exp(M dt) z(t) for the states of the virtual test, any dt: exact but for rounding (Taylor's series of
// steps so short that its remainder is below the last bit). A dt that comes again, as of instants on a grid, is moved
// by the matrix exponential, kept; any other by the series on the states themselves. Internal to the room.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "core/verify/virtual_test_model.hpp"

namespace dwell {

class VirtualTestSteps {
 public:
  // The model must outlive it.
  explicit VirtualTestSteps(const VirtualTestModel& model) : model_(model) {}

  // Moves the columns of `z` (states + kInput rows) on; what becomes of the last kInput rows is not given. dt_ns >= 0.
  void apply(std::int64_t dt_ns, Eigen::MatrixXd& z);

 private:
  struct Kept {
    std::int64_t dt_ns = -1;
    bool again = false;
    Eigen::MatrixXd exponential;  // its rows of states
  };
  static constexpr std::size_t kSlots = 64;  // a power of two; instants on a grid have a handful of steps

  void series(double dt_s, Eigen::MatrixXd& z);

  const VirtualTestModel& model_;
  std::array<Kept, kSlots> kept_;
  Eigen::MatrixXd term_, product_;
};

}  // namespace dwell
