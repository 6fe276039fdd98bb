// Three simulated nodes and the master, in virtual time, as the tests of the master use them.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "drivers/canopen/words.hpp"
#include "tests/drivers/canopen_bench.hpp"

namespace dwell::canopen {

using rigsim::Transducer;
using test::CanopenBench;
using test::kRawOffset_ns;

// Channels 10, 11, 12: nodes 1 (encoder), 2 (input), 5 (load cell).
class Canopen : public ::testing::Test {
 protected:
  void start() {
    bench_.start();
    ASSERT_TRUE(bench_.run_until([&] { return all_deliver(); }))
        << reason(10) << "; " << reason(11) << "; " << reason(12);
  }
  // Until the nodes have filled their dictionaries, and nobody has asked yet.
  void boot() { bench_.run_for(rigsim::CanopenNode::kBoot_ns + kMs_ns / 10); }
  bool all_deliver() const { return bench_.delivers(10) && bench_.delivers(11) && bench_.delivers(12); }
  std::string reason(std::uint16_t channel) const { return bench_.host.state_of(channel).reason; }
  dwell_fault fault(std::uint16_t channel) const { return bench_.host.state_of(channel).fault; }
  // Channel 13: another object of node 2, alone in its TPDO 2. Until node 2 boots again.
  void start_with_two_tpdos() {
    const Object object{0x7130, 1};
    bench_.setup.channels.push_back({13, "channel", 1});
    bench_.setup.nodes[1].wanted.push_back({object, *profile_type(object.index), 3});
    bench_.start();
    boot();
    bench_.node(2).set_entry(0x7130, 1, 7, 2, false);
    bench_.node(2).set_entry(0x1A01, 0, 1, 1, false);
    bench_.node(2).set_entry(0x1A01, 1, 0x71300110, 4, false);
    ASSERT_TRUE(bench_.run_until([&] { return all_deliver() && bench_.delivers(13); })) << reason(13);
  }
  // How often node 2 was told to reset its communication.
  std::ptrdiff_t resets() const {
    return std::count_if(bench_.sent.begin(), bench_.sent.end(), [](const can_frame& frame) {
      return frame.can_id == kNmt && frame.data[0] == 0x82 && frame.data[1] == 2;
    });
  }
  bool logged(const std::string& text) const {
    for (const std::string& line : bench_.host.logged())
      if (line.find(text) != std::string::npos) return true;
    return false;
  }
  // Every sample is what its node had at the instant it carries, which is a SYNC's.
  void expect_samples_of_their_sync(std::size_t from = 0) {
    const std::set<std::int64_t> syncs(bench_.syncs.begin(), bench_.syncs.end());
    const auto samples = bench_.host.samples();
    for (std::size_t i = from; i < samples.size(); ++i) {
      const dwell_sample& sample = samples[i];
      ASSERT_EQ(syncs.count(sample.t_ns), 1U);
      const std::uint8_t node = sample.channel == 10 ? 1 : sample.channel == 11 ? 2 : 5;
      const double si = bench_.quantity(node, sample.t_ns);
      ASSERT_NEAR(sample.raw, node == 5 ? si : si / 1e-9, node == 5 ? 1e-6 : 0.6) << sample.channel << " at " << i;
    }
  }
  void move() {
    bench_.quantity = [](std::uint8_t node, std::int64_t raw_ns) {
      return 1e-3 * node *
             std::sin(2e-9 * M_PI * 4.0 * static_cast<double>(raw_ns - kRawOffset_ns - 1'000 * kSecond_ns));
    };
  }

  CanopenBench bench_{{{1, Transducer::encoder}, {2, Transducer::input}, {5, Transducer::load_cell}}};
};

}  // namespace dwell::canopen
