// Mistakes in [[device]], in the keys that belong to the plugins, and in how fast the devices are read. "@" marks where
// each is expected to be reported.
#include <gtest/gtest.h>

#include "tests/config/fake_drivers.hpp"

namespace dwell::config::testing {
namespace {

TEST(DeviceMistakes, OfNames) {
  expect_mistake("[[device]]\nname = \"bus\"\n", "[[device]]\nname = @3\n",
                 "\"name\" is an integer: expected the device's name, printable text");
}

TEST(DeviceMistakes, OfTwoWithOneName) {
  const Edited edit = edited("name = \"bus\"", "name = \"amplifier\"");
  EXPECT_EQ(mistakes_in(edit.text),
            "rig.toml:41:8: two devices are named \"amplifier\", the first in line 31: expected a name of its own\n"
            "rig.toml:84:10: no device is named \"bus\": expected \"amplifier\", \"amplifier\"\n");
}

TEST(DeviceMistakes, OfDriversThatDoNotExist) {
  const Edited edit = edited("\"picky\"", "@\"pikcy\"");
  EXPECT_EQ(mistakes_in(edit.text),
            "rig.toml:42:10: driver \"pikcy\" is not available: expected one of modbus, replay, picky\n");
  const std::string letters = ": expected the name of a plugin, of the letters a-z, digits, - and _";
  expect_mistake("\"picky\"", "@\"../../evil\"", "\"driver\" is \"../../evil\"" + letters);
  expect_mistake("driver = \"picky\"", "driver = @7",
                 "\"driver\" is an integer: expected the name of a plugin, for instance \"modbus\"");
  const SchemaSource empty_handed = [](std::string_view) { return nullptr; };
  const std::string both = mistakes_in(kGoodRig, empty_handed);
  EXPECT_EQ(both,
            "rig.toml:32:10: driver \"modbus\" is not available: expected the name of an installed plugin\n"
            "rig.toml:42:10: driver \"picky\" is not available: expected the name of an installed plugin\n");
}

TEST(DeviceMistakes, OfTheCommonKeys) {
  expect_mistake("delay = 0.001", "delay = @\"1 ms\"", "\"delay\" is a string: expected a number from -10 to 10 (s)");
  expect_mistake("delay_u = 1e-4", "delay_u = @-1e-4", "\"delay_u\" is -0.0001: expected a number from 0 to 10 (s)");
}

TEST(DeviceMistakes, OfTheClock) {
  expect_mistake("rate = 500", "rate = 500\nclock = @\"own\"", "\"clock\" is \"own\": expected \"host\" or \"device\"");
  expect_good("rate = 500", "rate = 500\nclock = \"device\"");
  // A device whose driver has no key of that name may state its rate all the same.
  expect_good("driver = \"picky\"", "driver = \"picky\"\nclock = \"device\"\nrate = 1000");
  expect_mistake("driver = \"picky\"", "driver = \"picky\"\nrate = @0",
                 "\"rate\" is 0: expected a number from 0.001 to 1e6 (Hz)");
}

TEST(DeviceMistakes, OfAChannelThatNamesNoDevice) {
  expect_mistake("[[channel]]\nname = \"y0\"\ndevice = \"amplifier\"", "@[[channel]]\nname = \"y0\"",
                 "[[channel]] has no \"device\": expected the name of one of the devices", nullptr);
  expect_mistake("name = \"y0\"\ndevice = \"amplifier\"", "name = \"y0\"\ndevice = @\"amp\"",
                 "no device is named \"amp\": expected \"amplifier\", \"bus\"");
}

TEST(DeviceMistakes, OfThePluginsOwnKeys) {
  expect_mistake("transport = \"tcp\"", "transport = @\"udp\"", "\"transport\" is \"udp\": expected one of tcp rtu");
  expect_mistake("port = 1502", "port = @\"1502\"",
                 "\"port\" is \"1502\": expected an integer, at least 1, at most 65535");
  expect_mistake("port = 1502", "port = @0", "\"port\" is 0: expected an integer, at least 1, at most 65535");
  expect_mistake("port = 1502", "port = @1502.0", "\"port\" is 1502: expected an integer, at least 1, at most 65535");
  expect_mistake("port = 1502", "@prot = 1502", "unknown key \"prot\" in [[device]]: did you mean \"port\"?");
  expect_mistake("rate = 500", "rate = @nan", "\"rate\" is nan: expected a number, at least 0.001, at most 10000 (Hz)");
  expect_mistake("host = \"127.0.0.1\"", "host = @[1]", "\"host\" is an array: expected text");
  expect_mistake("host = \"127.0.0.1\"", "host = @\"a\\u0000b\"", "\"host\" is \"a?b\": expected text");
  expect_mistake("register = 2", "register = @-2",
                 "\"register\" is -2: expected an integer, at least 0, at most 65535");
  expect_mistake("register = 2", "@ordre = \"abcd\"\nregister = 2",
                 "unknown key \"ordre\" in [[channel]]: did you mean \"order\"?");
  expect_mistake("[[device]]\nname = \"amplifier\"\ndriver = \"modbus\"\ntransport = \"tcp\"",
                 "@[[device]]\nname = \"amplifier\"\ndriver = \"modbus\"",
                 "[[device]] has no \"transport\": expected one of tcp rtu");
  expect_mistake("word = \"even\"", "flag = @1", "\"flag\" is 1: expected true or false");
  expect_mistake("word = \"even\"", "level = @true", "\"level\" is a truth value: expected a number (V)");
  expect_good("word = \"even\"", "flag = true\ncount = -9223372036854775808\nlevel = 3");
}

TEST(DeviceMistakes, OfAnotherDriversKeysAreUnknown) {
  expect_mistake("wire = \"even\"", "@register = 4",
                 "unknown key \"register\" in [[channel]]: expected name, device, measures, at, "
                 "relative_to, unit, positive, scale, offset, scale_u, delay, delay_u, lowpass, highpass, range, "
                 "calibration, wire");
}

TEST(DeviceMistakes, ThatThePluginsCheckFindsStandWhereTheKeysStand) {
  expect_mistake("word = \"even\"", "word = @\"odd\"", "this is odd: expected something even");
  expect_mistake("wire = \"even\"", "wire = @\"odd\"", "this is odd: expected something even");
  expect_mistake("", "@[[device]]\nname = \"idle\"\ndriver = \"picky\"\n", "no channel: expected at least one");
}

TEST(DeviceMistakes, OfTheSchemaKeepThePluginsCheckFromRunning) {
  const Edited edit = edited("word = \"even\"", "word = \"odd\"\nflag = @3");
  EXPECT_EQ(mistakes_in(edit.text), "rig.toml:44:8: \"flag\" is 3: expected true or false\n");
}

TEST(DeviceMistakes, OfASamplingRateTooLowForTheHarmonics) {
  expect_mistake("rate = 500", "rate = @39.9",
                 "\"rate\" is 39.9, too slow for 4 harmonics of 4 Hz: expected at least 2 (H + 1) f = 40 Hz");
  expect_good("rate = 500", "rate = 40");
  // The keys of a recording's rig file are not checked against a driver, but this one means the same everywhere.
  expect_mistake("rate = 500", "rate = @nan",
                 "\"rate\" is nan, too slow for 4 harmonics of 4 Hz: expected at least 2 (H + 1) f = 40 Hz", nullptr);
}

TEST(DeviceMistakes, OfDevicesThatAreNoTables) {
  EXPECT_EQ(mistakes_in("device = [3]\nrig = {name='a', boundary='clamped', masses=[]}\nexcitation = {frequency=4}\n"
                        "channel = [{name='y', measures='displacement', at=0, unit='m'},\n"
                        "{name='f', measures='force', at='ground', unit='N'}]\n"),
            "rig.toml:1:11: a device is an integer: expected a table [[device]]\n");
}

}  // namespace
}  // namespace dwell::config::testing
