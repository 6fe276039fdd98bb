// The rig files that ship: each loads without a mistake, and says what its comments say.
#include <gtest/gtest.h>

#include "tests/config/fake_drivers.hpp"

namespace dwell::config::testing {
namespace {

RigFile shipped(const std::string& name) {
  const std::string path = std::string(DWELL_SAMPLE_RIGS "/") + name;
  EXPECT_TRUE(load(path, nullptr)) << name << " does not load without its driver";
  Result<RigFile> file = load(path, fake_schemas());
  if (!file) ADD_FAILURE() << to_string(path, file.error());
  return file ? std::move(*file) : RigFile{};
}

TEST(SampleRigs, OfTheClampedChainIsTheSimulatorsDefault) {
  const RigFile file = shipped("clamped.toml");
  EXPECT_EQ(file.rig.boundary, Boundary::clamped);
  EXPECT_EQ(file.rig.masses, (std::vector<double>{12.0, 8.0, 5.0}));
  ASSERT_EQ(file.rig.channels.size(), 5u);
  const char* const names[] = {"y0", "y1", "y2", "y3", "reaction"};
  for (int i = 0; i < 5; ++i) {
    const Channel& channel = file.rig.channels[static_cast<std::size_t>(i)];
    EXPECT_EQ(channel.name, names[i]);
    EXPECT_EQ(channel.at, i < 4 ? i : kGround);
    for (const Entry& entry : file.devices[0].channels[static_cast<std::size_t>(i)].entries) {
      if (entry.key == "register") {
        EXPECT_EQ(std::get<std::int64_t>(entry.value), 2 * i);
      }
    }
  }
}

TEST(SampleRigs, OfTheSuspensionIsFreeAndHasASecondOpinion) {
  const RigFile file = shipped("suspension.toml");
  EXPECT_EQ(file.rig.boundary, Boundary::free);
  EXPECT_EQ(file.rig.mass_count(), 2);
  EXPECT_EQ(file.rig.channels[2].relative_to, 1);
  EXPECT_EQ(file.rig.channels[3].measures, Quantity::acceleration);
  EXPECT_EQ(file.rig.channels[4].measures, Quantity::auxiliary);
}

TEST(SampleRigs, OfTheShaftTurns) {
  const RigFile file = shipped("shaft.toml");
  EXPECT_EQ(file.rig.motion, Motion::rotation);
  EXPECT_EQ(file.rig.element_count(), 3);
}

TEST(SampleRigs, OfTheReplayIsOneElement) {
  const RigFile file = shipped("replay.toml");
  EXPECT_EQ(file.rig.mass_count(), 0);
  EXPECT_EQ(file.rig.element_count(), 1);
  EXPECT_EQ(file.devices[0].driver, "replay");
}

}  // namespace
}  // namespace dwell::config::testing
