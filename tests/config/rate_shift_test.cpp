// What the plugins say of their devices, and the rate that is chosen by it.
#include <gtest/gtest.h>

#include <algorithm>

#include "core/fit/folding.hpp"
#include "tests/config/fake_drivers.hpp"

namespace dwell::config::testing {
namespace {

RigFile with_rate(const std::string& keys) {
  Result<RigFile> file = parse(edited("rate = 500", keys).text, "rig.toml", fake_schemas());
  if (!file) ADD_FAILURE() << to_string("rig.toml", file.error());
  return file ? std::move(*file) : RigFile{};
}

// What the plugin is told.
double told_rate(const RigFile& file) {
  for (const Entry& entry : file.devices[0].entries)
    if (entry.key == "rate") return std::get<double>(entry.value);
  return 0.0;
}

TEST(RateShift, AMultipleOfTheDriveIsLeftByAtMostOnePercent) {
  const RigFile file = with_rate("rate = 40");  // ten samples a period of 4 Hz
  const double rate_hz = told_rate(file);
  EXPECT_NE(rate_hz, 40.0);
  EXPECT_LE(std::abs(rate_hz / 40 - 1), 0.01 + 1e-12);
  EXPECT_GT(worst_folding(rate_hz, 4, 4).distance_hz(), 1.0);
  EXPECT_EQ(worst_folding(40, 4, 4).distance_hz(), 0.0);
  EXPECT_EQ(file.devices[0].rate_hz, rate_hz);
  EXPECT_EQ(file.devices[0].asked_rate_hz, 40.0);
  EXPECT_EQ(file.rig.devices[0].rate_hz, rate_hz);
  const std::string note = rate_note(file, file.devices[0]);
  EXPECT_NE(note.find("instead of 40 Hz, at which harmonic 6 of the drive reads as harmonic 4"), std::string::npos)
      << note;
}

TEST(RateShift, ARateThatTheLineCannotCarryIsToldWithTheMostThatItCan) {
  DeviceSettings device;
  device.name = "amplifier";
  device.rate_hz = 500;
  EXPECT_TRUE(line_note(device).empty());
  device.most_rate_hz = 61.4;
  EXPECT_EQ(line_note(device),
            "device amplifier is asked for 500 Hz, its serial line carries 61.4 Hz at most: choose a higher "
            "baud, fewer registers or a lower rate");
  device.rate_hz = 61;
  EXPECT_TRUE(line_note(device).empty());
}

TEST(RateShift, TheRigFileMayForbidIt) {
  const RigFile file = with_rate("rate = 40\nrate_shift = false");
  EXPECT_EQ(told_rate(file), 40.0);
  EXPECT_FALSE(file.devices[0].asked_rate_hz);
  const std::string note = rate_note(file, file.devices[0]);
  EXPECT_NE(note.find("harmonic 6 of the drive, if there is any, folds onto harmonic 4"), std::string::npos) << note;
}

TEST(RateShift, ARateFarAboveTheDriveIsTakenAsItIs) {
  const RigFile file = with_rate("rate = 500");
  EXPECT_EQ(told_rate(file), 500.0);
  EXPECT_FALSE(file.devices[0].asked_rate_hz);
  EXPECT_TRUE(rate_note(file, file.devices[0]).empty());
}

TEST(RateShift, TheDriversDefaultCountsAsARateThatIsStated) {
  const RigFile file = with_rate("");
  EXPECT_EQ(file.devices[0].asked_rate_hz, 100.0);
  EXPECT_EQ(file.devices[0].rate_hz, told_rate(file));
}

TEST(RateShift, ARateTooSlowForTheHarmonicsIsAMistakeStatedOrNot) {
  std::string text = edited("rate = 500", "").text;
  text.replace(text.find("frequency = 4.0"), 15, "frequency = 20 ");
  text.replace(text.find("search = [3.9, 4.1]"), 19, "");
  EXPECT_EQ(mistakes_in(text),
            "rig.toml:30:1: \"rate\" is 100 by default, too slow for 4 harmonics of 20 Hz: expected at least "
            "2 (H + 1) f = 200 Hz\n");
}

TEST(RateShift, TheAgeOfReadingsIsTheDrivers) {
  const RigFile file = with_rate("rate = 500");
  EXPECT_EQ(file.devices[0].age_ns, 150'000'000);
  EXPECT_EQ(file.devices[1].age_ns, 0);  // its driver does not say
}

}  // namespace
}  // namespace dwell::config::testing
