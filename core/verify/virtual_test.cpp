#include "core/verify/virtual_test.hpp"

#include <algorithm>
#include <cassert>
#include <limits>
#include <utility>

#include "core/base/instants.hpp"
#include "core/verify/virtual_test_steps.hpp"

namespace dwell {
namespace {

using Eigen::Index;

// What one channel is asked for, and how far it has come.
struct Asked {
  std::int64_t delay_ns;
  const Instants* instants;
  PredictedReadings* readings;
  std::vector<std::pair<Index, double>> row;  // of h_c what is not zero
  std::size_t next = 0;

  [[nodiscard]] std::int64_t next_ns() const {
    return next < instants->size() ? (*instants)[next] - delay_ns : std::numeric_limits<std::int64_t>::max();
  }
  void read(const Eigen::MatrixXd& z) {
    const auto column = static_cast<Index>(next++);
    for (Index player = 0; player < z.cols(); ++player) {
      double sum = 0.0;
      for (const auto& [state, weight] : row) sum += weight * z(state, player);
      (*readings)(player, column) = sum;
    }
  }
};

// The test in motion: all players at one instant.
class VirtualCourse {
 public:
  VirtualCourse(const VirtualTestModel& model, const VirtualTestInput& input, const Eigen::MatrixXd& initial)
      : model_(model), input_(input), steps_(model), now_ns_(input.knot_ns(0)) {
    z_ = Eigen::MatrixXd::Zero(model.states() + VirtualTestModel::kInput, initial.cols());
    z_.topRows(model.states()) = initial;
    read_input();
  }
  // t_ns: from now on, within the input.
  void go_to(std::int64_t t_ns) {
    while (knot_ + 2 < input_.knots() && input_.knot_ns(knot_ + 1) <= t_ns) {
      steps_.apply(input_.knot_ns(knot_ + 1) - now_ns_, z_);
      now_ns_ = input_.knot_ns(++knot_);
      read_input();
    }
    if (t_ns == now_ns_) return;
    steps_.apply(t_ns - now_ns_, z_);
    now_ns_ = t_ns;
    read_input();
  }
  [[nodiscard]] const Eigen::MatrixXd& z() const noexcept { return z_; }

 private:
  void read_input() {
    input_.at(knot_, to_s(now_ns_ - input_.knot_ns(knot_)),
              z_.block(model_.states(), 0, VirtualTestModel::kInput, input_.readings()));
  }

  const VirtualTestModel& model_;
  const VirtualTestInput& input_;
  VirtualTestSteps steps_;
  Eigen::MatrixXd z_;
  std::int64_t now_ns_;
  std::size_t knot_ = 0;
};

}  // namespace

std::vector<PredictedReadings> VirtualTest::play(const VirtualTestInput& input, const Eigen::MatrixXd& initial,
                                                 const std::vector<Instants>& instants) const {
  assert(fault().empty() && initial.rows() == model_.states() && initial.cols() >= input.readings());
  std::vector<PredictedReadings> readings;
  std::vector<Asked> asked;
  readings.reserve(instants.size());
  for (std::size_t c = 0; c < instants.size(); ++c) {
    readings.push_back(PredictedReadings::Constant(initial.cols(), static_cast<Index>(instants[c].size()),
                                                   std::numeric_limits<double>::quiet_NaN()));
    if (instants[c].empty()) continue;
    Asked channel{model_.delay_ns(static_cast<int>(c)), &instants[c], &readings[c], {}};
    const Eigen::VectorXd row = model_.row(static_cast<int>(c));
    for (Index state = 0; state < row.size(); ++state)
      if (row(state) != 0.0) channel.row.emplace_back(state, row(state));
    while (channel.next_ns() < input.knot_ns(0)) ++channel.next;
    asked.push_back(std::move(channel));
  }
  VirtualCourse course(model_, input, initial);
  const std::int64_t end_ns = input.knot_ns(input.knots() - 1);
  for (;;) {
    std::int64_t next_ns = std::numeric_limits<std::int64_t>::max();
    for (const Asked& channel : asked) next_ns = std::min(next_ns, channel.next_ns());
    if (next_ns > end_ns) return readings;
    course.go_to(next_ns);
    for (Asked& channel : asked)
      while (channel.next_ns() == next_ns) channel.read(course.z());
  }
}

}  // namespace dwell
