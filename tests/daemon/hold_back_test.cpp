#include "daemon/acquire/hold_back.hpp"

#include <gtest/gtest.h>

#include "daemon/acquire/plugin.hpp"

namespace dwell {
namespace {

// A rig with `count` float32 channels on one serial line.
std::string serial_rig(int count, const std::string& keys) {
  std::string text = R"([rig]
name = "line"
motion = "translation"
boundary = "clamped"
masses = []
[excitation]
frequency = 0.5
minimum = 1e-5
[[device]]
name = "line"
driver = "modbus"
transport = "rtu"
serial = "/dev/null"
rate = 4
)" + keys;
  for (int i = 0; i < count; ++i)
    text += "[[channel]]\nname = \"c" + std::to_string(i) + "\"\ndevice = \"line\"\nmeasures = \"" +
            (i == 0   ? "displacement\"\nat = 0\nunit = \"m"
             : i == 1 ? "force\"\nat = \"ground\"\nunit = \"N"
                      : "auxiliary\"\nunit = \"V") +
            "\"\ntype = \"float32\"\nregister = " + std::to_string(2 * i) + "\n";
  return text;
}

std::int64_t hold_back_of(const std::string& text) {
  const auto file = config::parse(text, "rig.toml", [](std::string_view driver) {
    return acquire::load_plugin(std::string(driver), {DWELL_TEST_PLUGINS});
  });
  if (!file) {
    ADD_FAILURE() << config::to_string("rig.toml", file.error());
    return 0;
  }
  return hold_back_ns(*file);
}

// 62 values take 253 bytes: 144.9 ms at 19200 baud after a turnaround of up to 0.1 s, and 0.05 s for the host.
TEST(HoldBack, CoversTheDefaultsOfASerialLine) {
  EXPECT_GE(hold_back_of(serial_rig(62, "")), 294'000'000);
  EXPECT_LT(hold_back_of(serial_rig(62, "")), 400'000'000);
}

TEST(HoldBack, FollowsWhatTheRigFileStates) {
  EXPECT_LT(hold_back_of(serial_rig(62, "baud = 115200\n")), 200'000'000);
  EXPECT_GE(hold_back_of(serial_rig(2, "timeout = 0.8\n")), 850'000'000);
  EXPECT_EQ(hold_back_of(serial_rig(2, "timeout = 0.02\nbaud = 115200\n")), 100'000'000);
}

TEST(HoldBack, IsBoundedWhereSamplesGrowEverOlder) {
  config::RigFile file;
  file.devices.emplace_back().age_ns = DWELL_AGE_UNBOUNDED;
  EXPECT_EQ(hold_back_ns(file), 10'000'000'000);
}

}  // namespace
}  // namespace dwell
