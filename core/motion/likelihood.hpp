// The likelihood of a stretch of readings under the exact chain, its table an unknown process, with the score and the
// Fisher information of all unknowns: one pass of a Kalman filter and of its derivatives.
//
//   V = ½ Σ (ln S_i + e_i² / S_i)
//   ∂_a V = Σ [ e ∂_a e / S + ½ ∂_a S (1 - e²/S) / S ],   I_ab = Σ [ ∂_a e ∂_b e / S + ½ ∂_a S ∂_b S / S² ]
//
// Unknowns: θ (core/motion/unknowns.hpp), the state at the first instant, and a bias of each channel. The innovations
// are linear in the last two: Gauss-Newton finds them in one step, and directions that no reading tells of (the common
// gauge of the biases) are null directions of I. Source: docs/method.md, Any motion; Harvey 1989, sections 3.4 and 4.3.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "core/motion/motion_model.hpp"

namespace dwell {

struct MotionReading {
  std::int64_t t_ns = 0;  // of the motion: the stamp less the channel's stated delay
  int channel = 0;
  double value = 0.0;         // SI
  std::uint32_t half_ns = 0;  // half width of the instant's uncertainty
};

// From here on the table's motion has the intensity of that index (Unknown::intensity).
struct MotionStretch {
  std::int64_t from_ns = 0;
  int intensity = 0;
};

// What drives an input of the model (is_input()), per reading: its mean since the reading before, and at the instant.
struct MotionInput {
  std::vector<double> mean, now;
};

struct MotionData {
  std::vector<MotionReading> readings;   // by time; none of an auxiliary channel
  std::vector<MotionStretch> stretches;  // by time; the first from the beginning on. Empty: intensity 0 throughout
  std::vector<MotionInput> inputs{};     // one per input of the model, in the order of its parameters
  // Outside of [whole_from_ns, whole_to_ns) there are only readings of the table's channel, by which its activity is
  // judged (MotionRecorder).
  std::int64_t whole_from_ns = INT64_MIN, whole_to_ns = INT64_MAX;
  [[nodiscard]] bool is_whole_at(std::int64_t t_ns) const noexcept {
    return t_ns >= whole_from_ns && t_ns < whole_to_ns;
  }
};

struct MotionInnovation {
  std::int64_t t_ns = 0;
  double normalized = 0.0;  // e/√S
};

struct MotionUnknowns {
  Eigen::VectorXd theta;    // p
  Eigen::VectorXd initial;  // m, the state at the first reading
  Eigen::VectorXd bias;     // J
};

struct PassOptions {
  bool derivatives = true;        // by θ, the initial state and the biases
  bool keep_innovations = false;  // Pass::innovations, with the deformations
  double block_s = 0.0;           // > 0: Pass::meat from scores summed over blocks of that length
  // Shown, per reading, the state just after the reading before and the one predicted from it for this reading.
  std::function<void(const Eigen::VectorXd& before, const Eigen::VectorXd& predicted)> show{};
};

struct Pass {
  double V = 0.0;
  Eigen::VectorXd score;        // of (θ, initial, bias)
  Eigen::MatrixXd information;  // likewise
  Eigen::MatrixXd meat;         // Σ over blocks of score · score'
  int blocks = 0;
  std::vector<double> chi2;        // per channel: mean of e²/S
  std::vector<double> count;       // per channel: readings that count
  std::vector<double> unforeseen;  // per channel: mean of 1 - σ²/S: the part of S that is motion not foreseen
  std::vector<std::vector<MotionInnovation>> innovations;  // per channel, by time
  Eigen::VectorXd deformation;                             // per element: √2 times the standard deviation, m
  Eigen::VectorXd deformation_u;
};

// unknowns: sizes as the model's. V is not finite where the unknowns make no filter. O(readings · (p m² + …)).
// Allocates; thread-safe.
[[nodiscard]] Pass evaluate(const MotionModel& model, const MotionData& data, const MotionUnknowns& unknowns,
                            const PassOptions& options);

}  // namespace dwell
