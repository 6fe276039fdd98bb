#include "core/rig/unstated.hpp"

#include <gtest/gtest.h>

#include "tests/core/bench_rig.hpp"
#include "tests/core/expect.hpp"

namespace dwell {
namespace {

using Texts = std::vector<std::string>;

TEST(Unstated, ARigFileThatStatesNothingLeavesOutEverything) {
  EXPECT_EQ(unstated_uncertainties(rig_of(clamped_chain(), 4)),
            (Texts{"masses 1 and 2", "scales of all channels", "delays of all channels"}));
}

TEST(Unstated, NamesWhatIsLeftOutAndNoMore) {
  Rig rig = rig_of(clamped_chain(), 4);
  rig.mass_u = {0.0, 0.0};  // known exactly, as stated
  rig.devices = {{"a", 0.0, 1e-4}};
  rig.channels[0].device = rig.channels[1].device = 0;
  rig.channels[0].scale_u = 1e-3;
  rig.channels[2].stated.scale_u = true;  // as 0
  rig.channels[2].lowpass = {FilterKind::butterworth, 2, 60, 0};
  EXPECT_EQ(unstated_uncertainties(rig),
            (Texts{"scales of y1 and reaction", "delays of y2 and reaction", "low-pass of y2"}));
  for (Channel& channel : rig.channels) channel.scale_u = 1e-3, channel.stated.delay_u = true;
  rig.channels[2].lowpass.hz_u = 0.5;
  EXPECT_TRUE(unstated_uncertainties(rig).empty());
}

TEST(Unstated, AuxiliaryChannelsNeedNone) {
  Rig rig = rig_of({Boundary::clamped, {}, {1e5}, {50}}, 4);
  Channel oil;
  oil.measures = Quantity::auxiliary;
  rig.channels.push_back(oil);
  EXPECT_EQ(unstated_uncertainties(rig), (Texts{"scales of all channels", "delays of all channels"}));
}

TEST(Unstated, EveryDwellSaysSo) {
  Bench bench({Boundary::clamped, {}, {1e5}, {50}}, rig_of({Boundary::clamped, {}, {1e5}, {50}}, 4), steady_drive(4),
              DrivenChain::Start::steady, {.rate_hz = 190, .sigma = {}});
  bench.run(5);
  EXPECT_EQ(bench.pipeline.current().unstated, (Texts{"scales of all channels", "delays of all channels"}));
}

}  // namespace
}  // namespace dwell
