// A simulated bench for the tests of core: a chain driven harmonically, its transducers, their samples as records.
#pragma once

#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "core/dwell/pipeline.hpp"
#include "core/model/chain.hpp"
#include "core/model/driven_chain.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// A rig with displacement transducers at the table and every mass, and a load cell on the ground if clamped.
inline Rig rig_of(const Chain& chain, double frequency_hz) {
  Rig rig;
  rig.name = "test";
  rig.boundary = chain.boundary;
  rig.masses = chain.masses;
  rig.excitation.frequency_hz = frequency_hz;
  rig.excitation.clock_u = 0.0;
  rig.excitation.minimum = 1e-6;
  rig.excitation.search_low_hz = 0.98 * frequency_hz;
  rig.excitation.search_high_hz = 1.02 * frequency_hz;
  for (int k = 0; k <= chain.mass_count(); ++k) {
    Channel channel;
    channel.name = "y" + std::to_string(k);
    channel.at = k;
    rig.channels.push_back(channel);
  }
  if (chain.boundary == Boundary::clamped) {
    Channel force;
    force.name = "reaction";
    force.measures = Quantity::force;
    force.at = kGround;
    force.unit = "N";
    rig.channels.push_back(force);
  }
  return rig;
}

// What channel c of the rig reads at t, SI, by the exact motion.
inline double exact_reading(const Rig& rig, const ChainMotion& motion, int c) {
  const Channel& channel = rig.channels[static_cast<std::size_t>(c)];
  const auto pick = [&](int place) {
    if (place == kGround) return 0.0;
    const auto i = static_cast<std::size_t>(place);
    return channel.measures == Quantity::velocity       ? motion.velocity[i]
           : channel.measures == Quantity::acceleration ? motion.acceleration[i]
                                                        : motion.y[i];
  };
  if (channel.measures == Quantity::force) return channel.force_on_mass ? -motion.ground_force : motion.ground_force;
  return pick(channel.at) - (channel.relative_to ? pick(*channel.relative_to) : 0.0);
}

struct Sampling {
  double rate_hz = 200.0;
  double skew_s = 0.0;                  // channel c is read c·skew_s after channel 0 …
  double jitter = 0.0;                  // … and each instant moves by ± this part of the interval, uniformly
  std::vector<double> sigma;            // absolute, SI, per channel; empty: none
  bool stamps_as_simultaneous = false;  // every sample of a scan carries the scan's instant
};

// Streams the chain's motion into the pipeline and keeps the dwells that it completes.
class Bench {
 public:
  Bench(const Chain& chain, const Rig& rig, const Drive& drive, DrivenChain::Start start, Sampling sampling,
        std::uint64_t seed = 1)
      : rig_(rig), motion_(chain, drive, start), sampling_(std::move(sampling)), rng_(seed), pipeline(rig) {}

  // Runs until t_end_s; returns at the first record after which `until` holds, if given.
  void run(double t_end_s, const std::function<bool()>& until = {}) {
    std::uniform_real_distribution<double> uniform(-1, 1);
    std::normal_distribution<double> normal;
    const int channels = static_cast<int>(rig_.channels.size());
    struct Due {
      double t;
      int c;
    };
    std::vector<Due> scan;
    while (t_ < t_end_s) {
      scan.clear();
      for (int c = 0; c < channels; ++c)
        scan.push_back({t_ + c * sampling_.skew_s + sampling_.jitter * uniform(rng_) / sampling_.rate_hz, c});
      std::stable_sort(scan.begin(), scan.end(), [](const Due& a, const Due& b) { return a.t < b.t; });
      if (sampling_.jitter == 0 && sampling_.skew_s == 0)
        for (Due& due : scan) due.t = t_;
      for (const Due& due : scan) {
        if (due.t < 0) continue;
        Record record;
        record.t_ns = std::llround((sampling_.stamps_as_simultaneous ? t_ : due.t) * 1e9);
        const double exact_t = sampling_.stamps_as_simultaneous ? due.t : 1e-9 * static_cast<double>(record.t_ns);
        record.value = exact_reading(rig_, motion_.at(exact_t), due.c);
        if (!sampling_.sigma.empty()) record.value += sampling_.sigma[static_cast<std::size_t>(due.c)] * normal(rng_);
        record.channel = static_cast<std::uint16_t>(due.c);
        if (alter) alter(record, due.t);
        push(record);
      }
      t_ = ++scans_ / sampling_.rate_hz;
      if (until && until()) return;
    }
  }
  void push(const Record& record) {
    if (pipeline.push(record) & kCompleted) dwells.push_back(pipeline.completed());
  }
  void finish() {
    if (pipeline.finish() & kCompleted) dwells.push_back(pipeline.completed());
  }
  [[nodiscard]] double now_s() const { return t_; }
  void set_drive(const Drive& drive) { motion_.set_drive(t_, drive); }

 private:
  Rig rig_;
  DrivenChain motion_;
  Sampling sampling_;
  std::mt19937_64 rng_;
  double t_ = 0.0;
  double scans_ = 0.0;

 public:
  Pipeline pipeline;
  std::vector<Dwell> dwells;
  std::function<void(Record&, double)> alter;  // disturbs a record on its way
};

inline Chain clamped_chain() {
  return {Boundary::clamped, {12.5, 8.0}, {24000.0, 15000.0, 9000.0}, {60.0, 45.0, 30.0}};
}
inline Chain free_chain() { return {Boundary::free, {250.0, 40.0}, {180000.0, 20000.0}, {900.0, 1500.0}}; }

// A chain drawn at random whose modes lie about the drive, damping ratios of a few percent.
inline Chain random_chain(std::mt19937_64& rng, int n, Boundary boundary, double frequency_hz) {
  std::uniform_real_distribution<double> uniform(0, 1);
  Chain chain;
  chain.boundary = boundary;
  const double omega = 2 * M_PI * frequency_hz;
  for (int k = 0; k < n; ++k) chain.masses.push_back(5 + 20 * uniform(rng));
  for (int e = 0; e < chain.element_count(); ++e) {
    const double c = 15 * omega * omega * (0.5 + 3 * uniform(rng));
    chain.stiffness.push_back(c);
    chain.damping.push_back(c / omega * (0.05 + 0.3 * uniform(rng)));
  }
  return chain;
}

}  // namespace dwell
