#include "tests/rigsim/knocks.hpp"

#include <algorithm>

namespace rigsim {

std::string Knocking::fault(const dwell::Chain& chain) const {
  if (chain.mass_count() < 1) return "expected a chain with masses";
  if (mass < 1 || mass > chain.mass_count()) return "expected a mass 1 ... " + std::to_string(chain.mass_count());
  if (!(every_s >= kMostOften_s)) return "expected 0.1 s or more from knock to knock on average";
  if (!(until_s >= 0)) return "expected an end at 0 s or later";
  return {};
}

Knocker::Knocker(const std::vector<Knocking>& kinds, std::uint64_t seed) {
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    // Not the readings' random numbers: knocks leave noise and losses of the same seed as they are.
    std::seed_seq own{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32),
                      static_cast<std::uint32_t>(i), 0x6B6E6F63U};
    kinds_.push_back({kinds[i], std::mt19937_64(own), 0.0});
    Kind& kind = kinds_.back();
    kind.next_s = std::exponential_distribution<double>(1 / kind.knocking.every_s)(kind.random);
  }
}

std::optional<Knock> Knocker::due(double t_s) {
  const auto next =
      std::min_element(kinds_.begin(), kinds_.end(), [](const Kind& a, const Kind& b) { return a.next_s < b.next_s; });
  if (next == kinds_.end() || next->next_s > t_s) return std::nullopt;
  const Knocking& of = next->knocking;
  if (next->next_s > of.until_s) {
    next->next_s = std::numeric_limits<double>::infinity();
    return due(t_s);
  }
  const Knock knock{next->next_s, of.mass, of.impulse};
  next->next_s += std::exponential_distribution<double>(1 / of.every_s)(next->random);
  return knock;
}

Ringing::Ringing(const dwell::Chain& chain) : free_(chain, {}, dwell::DrivenChain::Start::rest) {}

void Ringing::knock(double t_s, int mass, double velocity) {
  const std::size_t n = free_.at(0.0).y.size() - 1;
  State state{t_s, std::vector<double>(n), std::vector<double>(n)};
  if (!states_.empty()) {
    state.t_s = std::max(t_s, states_.back().t_s);
    const dwell::ChainMotion& motion = since(states_.back(), state.t_s);
    std::copy(motion.y.begin() + 1, motion.y.end(), state.y.begin());
    std::copy(motion.velocity.begin() + 1, motion.velocity.end(), state.velocity.begin());
  }
  state.velocity[static_cast<std::size_t>(mass - 1)] += velocity;
  states_.push_back(std::move(state));
  while (states_.size() > 1 && states_[1].t_s < states_.back().t_s - kRemembered_s) states_.pop_front();
}

void Ringing::add_to(double t_s, dwell::ChainMotion& motion) {
  const auto after = std::upper_bound(states_.begin(), states_.end(), t_s,
                                      [](double at, const State& state) { return at < state.t_s; });
  if (after == states_.begin()) return;
  const dwell::ChainMotion& free = since(*std::prev(after), t_s);
  for (std::size_t k = 0; k < motion.y.size(); ++k) {
    motion.y[k] += free.y[k];
    motion.velocity[k] += free.velocity[k];
    motion.acceleration[k] += free.acceleration[k];
  }
  motion.ground_force += free.ground_force;
}

// The chain does not age, so that its time may begin at each knock.
const dwell::ChainMotion& Ringing::since(const State& state, double t_s) {
  free_.set_state(0.0, state.y, state.velocity);
  return free_.at(t_s - state.t_s);
}

}  // namespace rigsim
