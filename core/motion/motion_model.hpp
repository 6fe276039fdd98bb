// The chain, its table and its transducers as one linear system in continuous time:
//
//   x' = A x + √q g w,   reading_j(t) = C_j x(t - τ_j) + bias_j + noise_j
//
// State, with ω₀ the nominal drive: (s, s'/ω₀, s''/ω₀² …; d_1 … d_n; d_1'/ω₀ …; states of the filters), all in the unit
// of a displacement. The table is what a constant and a sine of the drive's frequency ω become under white noise of
// intensity q, in m²/s: s''' = -ω² s' + √q ω₀² w (one derivative more where an accelerometer on the table has to be
// differentiated by a delay). A steady drive leaves q near 0, so that the sine itself carries the estimate; towards
// high frequencies it is the Wiener process of the acceleration, which follows ramps, knocks and random motion. Another
// process: TableProcess. d_k =
// y_k - y_{k-1}: a free chain feels the table's acceleration alone, and a transducer across an element keeps every
// digit. With d_{n+1} = -y_n for clamped, and f_k = c_k d_k + r_k d_k':
//
//   m_k y_k'' = f_{k+1} - f_k - g_k y_k - h_k y_k',   d_k'' = y_k'' - y_{k-1}'',   force on the ground = -f_{n+1}
//
// g_k and h_k are the stiffness and damping between mass k and the ground (Unknown::ground_stiffness, ground_damping);
// s_ab is the stiffness between places a and b that no element joins (Unknown::side_stiffness). It adds
// s_ab (y_b - y_a) to m_a y_a'' and the opposite to m_b y_b''. All three are 0 unless they are tested as missing. A and
// C are linear in c, r, g, h and s, and in 1/m. An input (is_input()) of amplitude a adds a u(t) to f_k: B a u to x',
// D a u to the reading. docs/method.md, Any motion.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/motion/unknowns.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// The system at one value of the unknowns, with derivatives by each. Shapes: m states, J channels.
struct LinearModel {
  Eigen::MatrixXd A;                // m × m, 1/s
  Eigen::MatrixXd C;                // J × m; zero rows for auxiliary channels
  std::vector<Eigen::MatrixXd> dA;  // per parameter; empty where A does not depend on it
  std::vector<Eigen::MatrixXd> dC;  // likewise, of C
  int noise_state = 0;              // where g has its one
  // Of the inputs, in the order of their parameters: what one of amplitude 1 adds to x' and to the readings.
  Eigen::MatrixXd B, D;     // m × inputs, J × inputs
  std::vector<int> inputs;  // their parameters
};

// What the table's motion is taken for: what becomes of a drive of frequency ω under white noise w.
enum class TableProcess : std::uint8_t {
  wandering,  // s''' = -ω² s' + √q ω₀² w: offset and phasor of the drive wander
  // s'''' = -2ω² s'' - ω⁴ (s - o) + √q ω₀³ w, the offset o constant: the phasor changes at a rate that wanders, as in
  // swells. States s, s'/ω₀ … s'''/ω₀³, o.
  swelling,
};

class MotionModel {
 public:
  MotionModel(const Rig& rig, std::vector<Parameter> parameters, TableProcess process = TableProcess::wandering);

  [[nodiscard]] int states() const noexcept { return states_; }
  [[nodiscard]] int table_states() const noexcept { return table_; }
  [[nodiscard]] const Rig& rig() const noexcept { return rig_; }
  [[nodiscard]] const std::vector<Parameter>& parameters() const noexcept { return parameters_; }
  // Delay of channel c as stated, its device's included, s.
  [[nodiscard]] double delay_s(int c) const;

  // theta: one value per parameter. derivatives: false leaves dA and dC empty. Allocates, thread-safe.
  [[nodiscard]] LinearModel at(const Eigen::VectorXd& theta, bool derivatives = true) const;

  // Rows that give the deformation of element k = 1 … and its rate, per s, from the state.
  [[nodiscard]] Eigen::RowVectorXd deformation_row(int k) const;
  [[nodiscard]] Eigen::RowVectorXd rate_row(int k) const;
  // Row that gives the velocity of mass k = 1 …, in displacement per s, from the state.
  [[nodiscard]] Eigen::RowVectorXd velocity_row(int k) const;

 private:
  struct Coefficients {
    Eigen::VectorXd stiffness, damping, inverse_mass;
    Eigen::VectorXd ground_stiffness, ground_damping;  // per mass
    Eigen::VectorXd side_stiffness;                    // per pair of places: apart()
    double drive = 0.0;
  };
  enum class Of { all, change_of_elements, change_of_masses };
  struct Parts {
    Eigen::MatrixXd A, C;  // of table and chain; C before filters
  };
  [[nodiscard]] Eigen::RowVectorXd force_row(const Coefficients& of, int k) const;
  // Force on mass k of the springs between places that no element joins.
  [[nodiscard]] Eigen::RowVectorXd side_row(const Coefficients& of, int k) const;
  // y_k''; linear in the coefficients for k > 0.
  [[nodiscard]] Eigen::RowVectorXd acceleration_row(const Coefficients& of, int k) const;
  [[nodiscard]] Eigen::RowVectorXd place_row(const Coefficients& of, Quantity quantity, int place) const;
  // The channel's row of C before its filters; only the part that `what` names.
  [[nodiscard]] Eigen::RowVectorXd channel_row(const Coefficients& of, const Channel& channel, Of what) const;
  // A and C are linear in the coefficients of the elements, and in 1/m: with a change of one in place of these
  // coefficients the parts that do not depend on it are left out.
  [[nodiscard]] Parts parts(const Coefficients& of, Of what) const;
  void add_filters(Parts& to, bool change) const;
  [[nodiscard]] Parts corner_derivative(const Parts& at, int c, bool high) const;
  [[nodiscard]] Parts derivative(const Parameter& by, const Coefficients& at, const Parts& here) const;
  void add_inputs(const Coefficients& now, const Parts& here, LinearModel& out) const;
  // What channel c shows, from its row in `here`, with derivatives.
  void state_row(int c, const Eigen::VectorXd& theta, const Parts& here, LinearModel& out) const;

  // The state that the noise enters: the highest derivative of s.
  [[nodiscard]] int noise_state() const noexcept { return table_ - (process_ == TableProcess::swelling ? 2 : 1); }
  // Fills in that state's row of A, or its derivative by the drive's relative departure.
  void add_process(double drive, bool derivative, Eigen::MatrixXd& A) const;

  Rig rig_;
  std::vector<Parameter> parameters_;
  TableProcess process_;
  std::vector<std::pair<int, int>> apart_;
  double omega0_;
  int n_, table_, states_;
  std::vector<int> filters_at_;  // per channel: where its filters' states begin
};

}  // namespace dwell
