// Knocks on the rig: impulses to its masses. Each lets one mass's velocity jump by impulse / mass. Displacements, the
// table and the drive go on as they were.
//
// The chain is linear: what it does after knocks is what its drive does, plus its free response to each of them.
#pragma once

#include <cstdint>
#include <deque>
#include <limits>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "core/model/driven_chain.hpp"

namespace rigsim {

// Knocks of one size to one mass, at random instants: the gaps between them are exponential (a Poisson process). Plain
// data.
struct Knocking {
  int mass = 1;          // 1 … n
  double impulse = 0.0;  // N·s, towards +y
  double every_s = 0.0;  // mean gap, kMostOften_s or more: bounds what a reading after a long silence has to catch up
  double until_s = std::numeric_limits<double>::infinity();  // ≥ 0, of the rig's time; none after it

  static constexpr double kMostOften_s = 0.1;

  // What of it this chain cannot have, as "expected …", or empty.
  [[nodiscard]] std::string fault(const dwell::Chain& chain) const;
};

struct Knock {
  double t_s;
  int mass;
  double impulse;  // N·s
};

// The instants, of several kinds of knocks at once; each kind has random numbers of its own. Bound to one thread.
class Knocker {
 public:
  Knocker(const std::vector<Knocking>& kinds, std::uint64_t seed);

  // The earliest knock not given yet, if it comes at t or before; none: nothing is due. Call until none.
  std::optional<Knock> due(double t_s);

 private:
  struct Kind {
    Knocking knocking;
    std::mt19937_64 random;
    double next_s;
  };
  std::vector<Kind> kinds_;
};

// The free response of a linear chain to all knocks so far: exact, as core/model/driven_chain.hpp. Bound to one thread.
class Ringing {
 public:
  explicit Ringing(const dwell::Chain& chain);

  // At t, or at the knock before where that is later. O(n²), and allocates.
  void knock(double t_s, int mass, double velocity);
  // Adds the response at t to a motion of the same chain. At the instant of a knock its velocity has jumped. Exact from
  // kRemembered_s before the last knock on.
  void add_to(double t_s, dwell::ChainMotion& motion);

  static constexpr double kRemembered_s = 2.0;

 private:
  struct State {
    double t_s;
    std::vector<double> y, velocity;  // of the masses
  };
  const dwell::ChainMotion& since(const State& state, double t_s);

  dwell::DrivenChain free_;   // its time begins at each knock
  std::deque<State> states_;  // just after each knock
};

}  // namespace rigsim
