// What a good file becomes.
#include "config/rig_file.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "config/sha256.hpp"
#include "tests/config/fake_drivers.hpp"

namespace dwell::config::testing {
namespace {

RigFile good(std::string_view text, const std::string& path = "/etc/dwell/rig.toml") {
  Result<RigFile> file = parse(text, path, fake_schemas());
  if (!file) ADD_FAILURE() << to_string(path, file.error());
  return file ? std::move(*file) : RigFile{};
}

TEST(RigFile, GivesTheMethodWhatTheFileSays) {
  const Rig rig = good(kGoodRig).rig;
  EXPECT_EQ(rig.name, "bench");
  EXPECT_EQ(rig.motion, Motion::translation);
  EXPECT_EQ(rig.boundary, Boundary::clamped);
  EXPECT_EQ(rig.masses, (std::vector<double>{12.0, 8.0}));
  EXPECT_EQ(rig.mass_u, (std::vector<double>{0.01, 0.02}));
  EXPECT_EQ(rig.excitation.frequency_hz, 4.0);
  EXPECT_EQ(rig.excitation.frequency_u_hz, 0.0002);
  EXPECT_EQ(rig.excitation.clock_u, 4e-5);
  EXPECT_EQ(rig.excitation.minimum, 2e-5);
  EXPECT_EQ(rig.excitation.search_low_hz, 3.9);
  EXPECT_EQ(rig.excitation.search_high_hz, 4.1);
  EXPECT_EQ(rig.excitation.reference, Reference::fixed);
  EXPECT_EQ(rig.excitation.harmonics, 4);
  EXPECT_EQ(rig.tolerance, 0.01);
  EXPECT_EQ(rig.memory_s, 300.0);
  EXPECT_EQ(rig.update_s, 0.2);
  ASSERT_EQ(rig.devices.size(), 2u);
  EXPECT_EQ(rig.devices[0].name, "amplifier");
  EXPECT_EQ(rig.devices[0].delay_s, 0.001);
  EXPECT_EQ(rig.devices[0].delay_u_s, 1e-4);
}

TEST(RigFile, GivesEveryChannelWhatTheFileSays) {
  const Rig rig = good(kGoodRig).rig;
  ASSERT_EQ(rig.channels.size(), 4u);
  const Channel& y0 = rig.channels[0];
  EXPECT_EQ(y0.name, "y0");
  EXPECT_EQ(y0.device, 0);
  EXPECT_EQ(y0.measures, Quantity::displacement);
  EXPECT_EQ(y0.at, 0);
  EXPECT_FALSE(y0.relative_to);
  EXPECT_EQ(y0.unit, "mm");
  EXPECT_EQ(y0.si_per_unit, 1e-3);
  EXPECT_EQ(y0.scale, -2.0);
  EXPECT_EQ(y0.offset, 0.5);
  EXPECT_EQ(y0.scale_u, 0.001);
  EXPECT_EQ(y0.delay_s, 0.0004);
  EXPECT_EQ(y0.delay_u_s, 2e-5);
  EXPECT_TRUE(y0.stated.scale_u && y0.stated.delay_u && y0.lowpass.hz_u_stated);
  EXPECT_EQ(y0.lowpass.kind, FilterKind::butterworth);
  EXPECT_EQ(y0.lowpass.order, 2);
  EXPECT_EQ(y0.lowpass.hz, 250.0);
  EXPECT_EQ(y0.lowpass.hz_u, 5.0);
  EXPECT_EQ(y0.highpass.kind, FilterKind::rc);
  EXPECT_EQ(y0.highpass.hz, 0.5);
  EXPECT_EQ(y0.range.low, -10.0);
  EXPECT_EQ(y0.range.high, 10.0);
  EXPECT_EQ(y0.calibration.id, "K-2231");
  EXPECT_EQ(y0.calibration.due, "2027-03-31");
  EXPECT_EQ(rig.channels[1].si_per_unit, 9.80665);
  EXPECT_EQ(rig.channels[2].relative_to, 1);
  EXPECT_EQ(rig.channels[3].device, 1);
  EXPECT_EQ(rig.channels[3].at, kGround);
  EXPECT_TRUE(rig.channels[3].force_on_mass);
  EXPECT_EQ(rig.channels[3].si_per_unit, 1000.0);
}

TEST(RigFile, GivesTheServiceWhatTheFileSays) {
  const RigFile file = good(kGoodRig);
  EXPECT_EQ(file.path, "/etc/dwell/rig.toml");
  EXPECT_EQ(file.directory, "/etc/dwell");
  EXPECT_EQ(file.server.listen.text, "[::1]:9000");
  EXPECT_EQ(file.server.listen.host, "::1");
  EXPECT_EQ(file.server.listen.port, 9000);
  EXPECT_TRUE(file.recording.on);
  EXPECT_EQ(file.recording.directory, "/etc/dwell/runs");
  EXPECT_EQ(file.recording.every_s, 1.0);
  EXPECT_FALSE(file.recording.retain_days || file.recording.retain_gigabytes || file.recording.anchor);
  EXPECT_EQ(good(kGoodRig, "rig.toml").directory, ".");
  const RigFile lamps =
      good(edited("",
                  "[gpio]\n"
                  "interlock = { chip = \"/dev/gpiochip0\", line = 4, active_low = true }\n"
                  "sync = { chip = \"/dev/gpiochip0\", line = 5, bias = \"pull-up\", debounce = 0.0005 }\n"
                  "ready = { chip = \"/dev/gpiochip0\", line = 6 }\n"
                  "fault = { chip = \"/dev/gpiochip1\", line = 6 }\n")
               .text);
  ASSERT_TRUE(lamps.gpio.interlock && lamps.gpio.sync && lamps.gpio.ready && lamps.gpio.fault);
  EXPECT_EQ(lamps.gpio.interlock->line, 4u);
  EXPECT_TRUE(lamps.gpio.interlock->active_low);
  EXPECT_EQ(lamps.gpio.sync->bias, GpioLine::Bias::pull_up);
  EXPECT_EQ(lamps.gpio.sync->debounce_s, 0.0005);
  EXPECT_EQ(lamps.gpio.fault->chip, "/dev/gpiochip1");
}

TEST(RigFile, HandsThePluginItsOwnKeysInTheTypesOfItsSchema) {
  const RigFile file = good(kGoodRig);
  ASSERT_EQ(file.devices.size(), 2u);
  EXPECT_EQ(file.devices[0].driver, "modbus");
  EXPECT_EQ(file.devices[0].rate_hz, 500.0);
  DriverSettings settings(file.devices[0], file.directory);
  const DriverSettings moved = std::move(settings);
  const dwell_settings& c = moved.get();
  EXPECT_EQ(c.size, sizeof(dwell_settings));
  EXPECT_STREQ(c.device, "amplifier");
  EXPECT_STREQ(c.directory, "/etc/dwell");
  ASSERT_EQ(c.entry_count, 4u);  // transport, host, port, rate; not name, driver, delay, delay_u
  for (std::size_t i = 0; i < c.entry_count; ++i) {
    const dwell_entry& entry = c.entries[i];
    if (std::string_view(entry.key) == "rate") {
      EXPECT_EQ(entry.type, DWELL_REAL) << "the file says 500, the schema a real number";
      EXPECT_EQ(entry.real, 500.0);
    } else if (std::string_view(entry.key) == "port") {
      EXPECT_EQ(entry.type, DWELL_INTEGER);
      EXPECT_EQ(entry.integer, 1502);
      EXPECT_EQ(entry.real, 1502.0);
    } else {
      EXPECT_EQ(entry.type, DWELL_STRING);
      EXPECT_STREQ(entry.string, std::string_view(entry.key) == "host" ? "127.0.0.1" : "tcp");
    }
  }
  ASSERT_EQ(c.channel_count, 3u);
  EXPECT_STREQ(c.channels[2].name, "d2");
  EXPECT_EQ(c.channels[2].index, 2u);
  ASSERT_EQ(c.channels[2].entry_count, 2u);  // register, type
  const DriverSettings bus(file.devices[1], file.directory);
  ASSERT_EQ(bus.get().channel_count, 1u);
  EXPECT_EQ(bus.get().channels[0].index, 3u) << "the rig's index, not the device's";
}

TEST(RigFile, HasTheDefaultsOfTheManual) {
  const RigFile file = good(R"([rig]
name = "mount"
boundary = "clamped"
masses = []
[excitation]
frequency = 10
[[device]]
name = "played"
driver = "replay"
file = "mount.csv"
[[channel]]
name = "y0"
measures = "displacement"
at = 0
unit = "mm"
[[channel]]
name = "f"
measures = "force"
at = "ground"
unit = "N"
)");
  const Rig& rig = file.rig;
  EXPECT_EQ(rig.motion, Motion::translation);
  EXPECT_EQ(rig.excitation.clock_u, 5e-5);
  EXPECT_EQ(rig.excitation.minimum, 1e-6);
  EXPECT_DOUBLE_EQ(rig.excitation.search_low_hz, 9.8);
  EXPECT_DOUBLE_EQ(rig.excitation.search_high_hz, 10.2);
  EXPECT_EQ(rig.excitation.reference, Reference::tracked);
  EXPECT_EQ(rig.excitation.harmonics, 3);
  EXPECT_EQ(rig.tolerance, 0.005);
  EXPECT_EQ(rig.memory_s, 600.0);
  EXPECT_EQ(rig.update_s, 0.1);
  EXPECT_TRUE(rig.mass_u.empty());
  EXPECT_FALSE(rig.channels[0].stated.scale_u || rig.channels[0].stated.delay_u) << "a 0 that is written is another";
  EXPECT_EQ(file.server.listen.text, "127.0.0.1:8380");
  EXPECT_EQ(file.server.listen.host, "127.0.0.1");
  EXPECT_EQ(file.server.listen.port, 8380);
  EXPECT_FALSE(file.recording.on) << "without the table nothing is recorded";
  EXPECT_EQ(file.recording.directory, "/var/lib/dwell");
  EXPECT_FALSE(file.gpio.sync);
  EXPECT_EQ(rig.channels[0].device, 0) << "of one device the name may be left out";
  EXPECT_EQ(rig.channels[0].lowpass.kind, FilterKind::none);
  EXPECT_FALSE(rig.channels[1].force_on_mass);
}

TEST(RigFile, SaysHowRunsAreKept) {
  const auto with = [](const std::string& more) {
    return good(edited("directory = \"runs\"", "directory = \"runs\"\n" + more).text).recording;
  };
  const RecordingSettings kept = with(
      "every = 0.5\nretain = { days = 400, gigabytes = 50.5 }\nanchor = { minutes = 5, file = \"/mnt/lab/heads\" }\n");
  EXPECT_EQ(kept.every_s, 0.5);
  EXPECT_EQ(kept.retain_days, 400.0);
  EXPECT_EQ(kept.retain_gigabytes, 50.5);
  ASSERT_TRUE(kept.anchor);
  EXPECT_EQ(kept.anchor->minutes, 5.0);
  EXPECT_EQ(kept.anchor->file, "/mnt/lab/heads");
  EXPECT_TRUE(kept.anchor->command.empty());
  EXPECT_EQ(with("anchor = { file = \"heads\" }").anchor->file, "/etc/dwell/heads") << "as every path in the file";
  EXPECT_EQ(with("anchor = { command = [\"/bin/send\", \"a b\"] }").anchor->command,
            (std::vector<std::string>{"/bin/send", "a b"}));
  EXPECT_EQ(with("anchor = { command = [\"/bin/send\"] }").anchor->minutes, 10.0);
}

TEST(RigFile, WithARecordingNeedsNoDevices) {
  constexpr std::string_view text = R"([rig]
name = "mount"
boundary = "clamped"
masses = []
[excitation]
frequency = 10
[[channel]]
name = "y0"
device = "an amplifier that is not described"
measures = "displacement"
at = 0
unit = "mm"
register = 7
[[channel]]
name = "f"
measures = "force"
at = "ground"
unit = "N"
message = { any = "thing" }
)";
  const Result<RigFile> file = parse(text, "rig.toml", nullptr);
  ASSERT_TRUE(file) << to_string("rig.toml", file.error());
  EXPECT_EQ(file->rig.channels[0].device, -1);
  EXPECT_TRUE(file->devices.empty());
}

TEST(RigFile, WithARecordingAcceptsTheRigFileOfTheService) {
  const Result<RigFile> file = parse(kGoodRig, "rig.toml", nullptr);
  ASSERT_TRUE(file) << to_string("rig.toml", file.error());
  EXPECT_EQ(file->rig.channels[3].device, 1);
  EXPECT_EQ(file->devices[0].rate_hz, 500.0);
}

TEST(RigFile, MeasuredAgainstTheGroundIsMeasuredAbsolutely) {
  const RigFile file = good(edited("relative_to = 1", "relative_to = \"ground\"").text);
  EXPECT_FALSE(file.rig.channels[2].relative_to);
}

TEST(RigFile, OfAnAuxiliaryChannelTakesAnyUnitAndNoPlace) {
  const RigFile file =
      good(edited("", "[[channel]]\nname = \"oil\"\ndevice = \"bus\"\nmeasures = \"auxiliary\"\nunit = \"°C\"\n").text);
  EXPECT_EQ(file.rig.channels[4].unit, "°C");
  EXPECT_EQ(file.rig.channels[4].si_per_unit, 1.0);
}

TEST(RigFile, IsKnownByItsBytes) {
  EXPECT_EQ(sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(good(kGoodRig).sha256, sha256(kGoodRig));
}

class OnDisk : public ::testing::Test {
 protected:
  void SetUp() override {
    char pattern[] = "/tmp/dwell-config-XXXXXX";
    ASSERT_NE(::mkdtemp(pattern), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  [[nodiscard]] std::string write(std::string_view text) const {
    std::ofstream(folder_ / "rig.toml") << text;
    return folder_ / "rig.toml";
  }
  std::filesystem::path folder_;
};

TEST_F(OnDisk, IsLoadedWithItsPath) {
  const std::string path = write(kGoodRig);
  const Result<RigFile> file = load(path, fake_schemas());
  ASSERT_TRUE(file) << to_string(path, file.error());
  EXPECT_EQ(file->path, path);
  EXPECT_EQ(file->directory, folder_);
  EXPECT_EQ(file->sha256, sha256(kGoodRig));
}

TEST_F(OnDisk, ThatCannotBeReadSaysWhy) {
  const Result<RigFile> absent = load(folder_ / "absent.toml", nullptr);
  ASSERT_FALSE(absent);
  EXPECT_EQ(to_string("F", absent.error()), "F: cannot be read: No such file or directory\n");
  const Result<RigFile> directory = load(folder_, nullptr);
  ASSERT_FALSE(directory);
  EXPECT_EQ(to_string("F", directory.error()), "F: is not a regular file: expected a rig file\n");
  const Result<RigFile> endless = load("/dev/zero", nullptr);
  ASSERT_FALSE(endless);
  EXPECT_EQ(to_string("F", endless.error()), "F: is not a regular file: expected a rig file\n");
}

TEST_F(OnDisk, ThatIsTooLargeIsRefused) {
  const Result<RigFile> file = load(write(std::string(kMaxFileBytes + 1, '\n')), nullptr);
  ASSERT_FALSE(file);
  EXPECT_EQ(to_string("F", file.error()), "F: is larger than a rig file may be: expected at most 1048576 bytes\n");
}

}  // namespace
}  // namespace dwell::config::testing
