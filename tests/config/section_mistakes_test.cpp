// Mistakes in [rig], [excitation], [settling], [estimation], [server], [recording] and [gpio]. "@" marks where each is
// expected to be reported.
#include <gtest/gtest.h>

#include "config/decimal_comma.hpp"
#include "tests/config/fake_drivers.hpp"

namespace dwell::config::testing {
namespace {

TEST(RigFileMistakes, OfSyntaxAreToldOneAtATimeWithTheirPosition) {
  EXPECT_EQ(mistakes_in("[rig]\nname = \n[rig]\n"),
            "rig.toml:2:8: Error while parsing key-value pair: expected value, saw '\\n'\n");
  EXPECT_EQ(mistakes_in("[rig]\nname = 1\nname = 2\n"),
            "rig.toml:3:8: Error while parsing key-value pair: cannot redefine existing integer 'name'\n");
}

TEST(RigFileMistakes, OfAnEmptyFileAreTheTablesItNeeds) {
  EXPECT_EQ(mistakes_in(""),
            "rig.toml:1:1: the file has no \"channel\": expected at least one table [[channel]]\n"
            "rig.toml:1:1: the file has no \"device\": expected at least one table [[device]]\n"
            "rig.toml:1:1: the file has no \"excitation\": expected a table [excitation]\n"
            "rig.toml:1:1: the file has no \"rig\": expected a table [rig]\n");
  EXPECT_EQ(
      mistakes_in("rig = 3\nexcitation = []\nserver = \"x\"\ndevice = 1\nchannel = [1, {}]\n"),
      "rig.toml:1:7: \"rig\" is an integer: expected a table [rig]\n"
      "rig.toml:2:14: \"excitation\" is an array: expected a table [excitation]\n"
      "rig.toml:3:10: \"server\" is a string: expected a table [server]\n"
      "rig.toml:4:10: \"device\" is an integer: expected at least one table [[device]]\n"
      "rig.toml:5:12: a channel is an integer: expected a table [[channel]]\n"
      "rig.toml:5:15: [[channel]] has no \"at\": expected 0 (the table) or \"ground\"\n"
      "rig.toml:5:15: [[channel]] has no \"measures\": expected \"displacement\", \"velocity\", \"acceleration\", "
      "\"force\" or \"auxiliary\"\n"
      "rig.toml:5:15: [[channel]] has no \"name\": expected printable text without commas and quotes, at most 64 "
      "bytes, not t, channel or value\n"
      "rig.toml:5:15: [[channel]] has no \"unit\": expected the unit of what the channel measures\n");
}

TEST(RigFileMistakes, OfNamesPointToTheNameThatWasMeant) {
  expect_mistake("frequency_u = 0.0002", "@frequencyu = 0.0002",
                 "unknown key \"frequencyu\" in [excitation]: did you mean \"frequency_u\"?");
  expect_mistake("clock_u = 4e-5", "@colck_u = 4e-5",
                 "unknown key \"colck_u\" in [excitation]: did you mean \"clock_u\"?");
  expect_mistake("[settling]\n", "[settling]\n@speed = 4\n", "unknown key \"speed\" in [settling]: expected tolerance");
  expect_mistake("[recording]", "[@recordings]", "unknown key \"recordings\" in the file: did you mean \"recording\"?");
  expect_mistake("mass_u = [0.01, 0.02]", "@weights = [0.01, 0.02]",
                 "unknown key \"weights\" in [rig]: expected name, motion, boundary, masses, mass_u");
}

TEST(RigFileMistakes, OfTheRigItself) {
  constexpr const char* name = ": expected the rig's name, printable text";
  expect_mistake("name = \"bench\"", "name = @3", std::string("\"name\" is an integer") + name);
  expect_mistake("name = \"bench\"", "name = @\"\"", std::string("\"name\" is empty") + name);
  expect_mistake("name = \"bench\"", "name = @\"a\\nb\"",
                 std::string("\"name\" holds control characters or is too long") + name);
  expect_mistake("[rig]\nname = \"bench\"", "@[rig]", std::string("[rig] has no \"name\"") + name);
  expect_mistake("\"translation\"", "@\"rotational\"",
                 "\"motion\" is \"rotational\": expected \"translation\" or \"rotation\"");
  expect_mistake("\"clamped\"", "@true", "\"boundary\" is a truth value: expected \"free\" or \"clamped\"");
  expect_mistake("[rig]\nname = \"bench\"\nmotion = \"translation\"\nboundary = \"clamped\"",
                 "@[rig]\nname = \"bench\"\nmotion = \"translation\"",
                 "[rig] has no \"boundary\": expected \"free\" or \"clamped\"");
}

TEST(RigFileMistakes, OfMassesPointToTheMass) {
  constexpr const char* kg = ": expected a number above 0 (kg, or kg*m2 for rotation)";
  expect_mistake("[12.0, 8.0]", "[12.0, @-8.0]", std::string("mass 2 is -8") + kg);
  expect_mistake("[12.0, 8.0]", "[@0, 8.0]", std::string("mass 1 is 0") + kg);
  expect_mistake("[12.0, 8.0]", "[@nan, 8.0]", std::string("mass 1 is nan") + kg);
  expect_mistake("[12.0, 8.0]", "[@inf, 8.0]", std::string("mass 1 is inf") + kg);
  expect_mistake("[12.0, 8.0]", "[12.0, @\"8 kg\"]", std::string("mass 2 is \"8 kg\"") + kg);
  expect_mistake("[12.0, 8.0]", "@12.0",
                 "\"masses\" is a number with a fraction: expected an array of numbers, each above 0 (kg, or kg*m2 for "
                 "rotation)");
  expect_mistake("[0.01, 0.02]", "@[0.01]", "\"mass_u\" has 1 entries: expected 2, one for each of \"masses\"");
  expect_mistake("[0.01, 0.02]", "[0.01, @-0.02]",
                 "the uncertainty of mass 2 is -0.02: expected a number 0 or more, in the unit of the mass");
  std::string many = "@[1";
  for (std::size_t i = 1; i < kMaxMasses + 1; ++i) many += ",1";
  expect_mistake("[12.0, 8.0]", many + "]", "\"masses\" has 101 entries: expected at most 100");
}

TEST(RigFileMistakes, OfTheExcitation) {
  constexpr const char* hz = ": expected a number from 0.001 to 100000 (Hz)";
  expect_mistake("frequency = 4.0", "frequency = @0.0", std::string("\"frequency\" is 0") + hz);
  expect_mistake("frequency = 4.0", "frequency = @-4", std::string("\"frequency\" is -4") + hz);
  expect_mistake("frequency = 4.0", "frequency = @nan", std::string("\"frequency\" is nan") + hz);
  expect_mistake("frequency = 4.0", "frequency = @\"4 Hz\"", std::string("\"frequency\" is a string") + hz);
  expect_mistake("[excitation]\nfrequency = 4.0", "@[excitation]",
                 std::string("[excitation] has no \"frequency\"") + hz);
  expect_mistake("frequency_u = 0.0002", "frequency_u = @-1",
                 "\"frequency_u\" is -1: expected a number from 0 to 100 (Hz)");
  expect_mistake("clock_u = 4e-5", "clock_u = @-1e-5",
                 "\"clock_u\" is -1e-05: expected a number from 0 to 0.01 (relative)");
  expect_mistake("clock_u = 4e-5", "clock_u = @50", "\"clock_u\" is 50: expected a number from 0 to 0.01 (relative)");
  expect_mistake("minimum = 2e-5", "minimum = @0.0",
                 "\"minimum\" is 0: expected a number above 0 (m, or rad for rotation)");
  expect_mistake("harmonics = 4", "harmonics = @0", "\"harmonics\" is 0: expected an integer from 1 to 8");
  expect_mistake("harmonics = 4", "harmonics = @9", "\"harmonics\" is 9: expected an integer from 1 to 8");
  expect_mistake("harmonics = 4", "harmonics = @3.0",
                 "\"harmonics\" is a number with a fraction: expected an integer from 1 to 8");
  expect_mistake("reference = \"fixed\"", "reference = @\"trakced\"",
                 "\"reference\" is \"trakced\": expected \"fixed\", \"tracked\" or \"sync\"");
  expect_mistake("reference = \"fixed\"", "reference = @\"sync\"",
                 "\"reference\" is \"sync\", and [gpio] has no \"sync\": expected the line of the sync input there");
}

TEST(RigFileMistakes, OfTheSearchInterval) {
  const std::string form = "[low, high] in Hz, 0 < low < high at most 1000 low, with \"frequency\" between them";
  const std::string expected = ": expected " + form;
  expect_mistake("[3.9, 4.1]", "@[4.1, 3.9]", "\"search\" is [4.1, 3.9]" + expected);
  expect_mistake("[3.9, 4.1]", "@[0.0041, 4.11]", "\"search\" is [0.0041, 4.11]" + expected);
  expect_mistake("[3.9, 4.1]", "@[0.0, 4.1]", "\"search\" is [0, 4.1]" + expected);
  expect_mistake("[3.9, 4.1]", "@[4.1, 4.3]", "\"search\" is [4.1, 4.3], without the frequency 4 in it" + expected);
  for (const std::string wrong : {"[nan, 4.1]", "[3.9, inf]"})
    expect_mistake("[3.9, 4.1]", "@" + wrong, "\"search\" is " + wrong + ": expected two finite numbers, " + form);
  for (const char* wrong : {"@[3.9]", "@[3.9, 4.1, 5.0]", "@[\"a\", 4.1]"}) {
    expect_mistake("[3.9, 4.1]", wrong, "\"search\" is not two numbers" + expected);
  }
  expect_mistake("[3.9, 4.1]", "@4.0", "\"search\" is a number with a fraction" + expected);
}

TEST(RigFileMistakes, OfSettlingAndEstimation) {
  constexpr const char* tolerance = ": expected a number above 0, at most 0.5 (relative)";
  expect_mistake("tolerance = 0.01", "tolerance = @0.0", std::string("\"tolerance\" is 0") + tolerance);
  expect_mistake("tolerance = 0.01", "tolerance = @0.6", std::string("\"tolerance\" is 0.6") + tolerance);
  expect_good("tolerance = 0.01", "tolerance = 0.5");
  expect_mistake("memory = 300", "memory = @-1", "\"memory\" is -1: expected a number above 0, at most 604800 (s)");
  expect_mistake("memory = 300", "memory = @1.2",
                 "a memory of 1.2 s holds 4.8 periods: expected 5 to 100000000, that is 1.25 to 25000000 s");
  expect_mistake("memory = 300", "memory = @604801",
                 "\"memory\" is 604801: expected a number above 0, at most 604800 (s)");
  expect_good("memory = 300", "memory = 1.25");
  for (const char* wrong : {"0", "-1", "nan", "1.5"})
    expect_mistake("update = 0.2", std::string("update = @") + wrong,
                   "\"update\" is " + std::string(wrong) + ": expected a number from 0.01 to 1 (s)");
  expect_good("update = 0.2", "update = 1");
}

TEST(RigFileMistakes, OfVerification) {
  constexpr const char* accuracy = ": expected a number above 0, at most 1 (of each channel's rms)";
  expect_good("[settling]", "[verification]\naccuracy = 0.02\n[settling]");
  expect_mistake("[settling]", "[verification]\naccuracy = @0\n[settling]",
                 std::string("\"accuracy\" is 0") + accuracy);
  expect_mistake("[settling]", "[verification]\naccuracy = @5\n[settling]",
                 std::string("\"accuracy\" is 5") + accuracy);
  expect_mistake("[settling]", "[verification]\n@limit = 5\n[settling]",
                 "unknown key \"limit\" in [verification]: expected accuracy, live");
  expect_good("[settling]", "[verification]\nlive = false\n[settling]");
  expect_mistake("[settling]", "[verification]\nlive = @0\n[settling]",
                 "\"live\" is an integer: expected true or false");
}

TEST(RigFileMistakes, OfADefaultThatDoesNotFitPointToWhatItDoesNotFit) {
  const std::string slow = edited("frequency = 4.0", "frequency = @0.005").text;
  const std::size_t search = slow.find("search = [3.9, 4.1]\n");
  std::string text = slow;
  text.erase(search, 20);
  text.erase(text.find("memory = 300\n"), 13);
  EXPECT_EQ(mistakes_in(text),
            "rig.toml:9:13: a memory of 600 s holds 3 periods: expected 5 to 100000000, that is 1000 to 2e+10 s (key "
            "\"memory\" in [estimation])\n");
}

TEST(RigFileMistakes, OfAMemoryOfTooManyPeriods) {
  EXPECT_EQ(mistakes_in("rig = {name='a', boundary='clamped', masses=[]}\nexcitation = {frequency=1e5}\n"
                        "estimation = {memory=3600}\n[[channel]]\nname='y'\nmeasures='displacement'\nat=0\nunit='m'\n"
                        "[[channel]]\nname='f'\nmeasures='force'\nat='ground'\nunit='N'\n",
                        nullptr),
            "rig.toml:3:22: a memory of 3600 s holds 360000000 periods: expected 5 to 100000000, that is 5e-05 to 1000 "
            "s\n");
}

TEST(RigFileMistakes, ADecimalCommaIsNamed) {
  expect_mistake("delay = 0.001", "delay = 0@,001",
                 "Error while parsing key-value pair: expected a comment or whitespace, saw ','; expected a decimal "
                 "point: 0.001");
  EXPECT_EQ(decimal_comma("a = 1\nb =  -12,50 # mm\n", 2), "-12.50");
  EXPECT_FALSE(decimal_comma("a = [1, 2\n", 1));
  EXPECT_FALSE(decimal_comma("a = [1,2", 1));
  EXPECT_EQ(decimal_comma("mass_u = [-0,01, 1]\n", 1), "-0.01");
  EXPECT_FALSE(decimal_comma("a = 1,\n", 1));
  EXPECT_FALSE(decimal_comma("a", 3));
  EXPECT_FALSE(decimal_comma("", 1));
}

TEST(RigFileMistakes, ADecimalCommaInAnArrayIsNamedWhereItsLengthDoesNotFit) {
  expect_mistake("[0.01, 0.02]", "@[0,5, 0.02]",
                 "\"mass_u\" has 3 entries: expected 2, one for each of \"masses\"; expected a decimal point: 0.5");
  expect_mistake("[0.01, 0.02]", "@[0.01]", "\"mass_u\" has 1 entries: expected 2, one for each of \"masses\"");
}

TEST(RigFileMistakes, OfTheListeningAddress) {
  const std::string expected =
      ": expected \"ADDRESS:PORT\" with a numeric address or localhost, for instance \"127.0.0.1:8380\" or "
      "\"[::1]:8380\"";
  for (const char* wrong :
       {"127.0.0.1", "127.0.0.1:", ":8380", "127.0.0.1:65536", "127.0.0.1:-1", "127.0.0.1:80x", "1.2.3.400:80",
        "1.2.3:80", "::1:8380", "[::1]", "[::g]:80", "bad host:80", "-a:80", "a:8 0", "host:8380",
        "bench-2.example.org:80"}) {  // the service binds addresses and looks up no names
    expect_mistake("\"[::1]:9000\"", "@\"" + std::string(wrong) + "\"",
                   "\"listen\" is \"" + std::string(wrong) + "\"" + expected);
  }
  for (const char* right : {"0.0.0.0:1", "localhost:65535", "[::]:8380", "127.0.0.1:0"}) {
    expect_good("\"[::1]:9000\"", "\"" + std::string(right) + "\"");
  }
  expect_mistake("\"[::1]:9000\"", "@8380", "\"listen\" is an integer" + expected);
}

TEST(RigFileMistakes, OfTheModbusServer) {
  const std::string expected =
      "expected \"ADDRESS:PORT\" with a numeric address or localhost, for instance \"127.0.0.1:1502\"";
  const std::string before = "\"[::1]:9000\"\n[modbus_server]\nlisten = ";
  expect_good("\"[::1]:9000\"", before + "\"0.0.0.0:1502\"");  // of a run that was recorded
  expect_good("\"[::1]:9000\"", before + "\"0.0.0.0:1502\"\nopen_to_network = true");
  expect_mistake("\"[::1]:9000\"", before + "\"0.0.0.0:1502\"\nopen_to_network = @\"yes\"",
                 "\"open_to_network\" is a string: expected true or false");
  expect_mistake("\"[::1]:9000\"", before + "@\"plc:1502\"", "\"listen\" is \"plc:1502\": " + expected);
  expect_mistake("\"[::1]:9000\"", "\"[::1]:9000\"\n@[modbus_server]",
                 "[modbus_server] has no \"listen\": " + expected);
}

TEST(RigFileMistakes, OfAnAddressOfManyComputers) {
  for (const std::string many : {"224.0.0.1:8380", "239.255.255.250:8380", "255.255.255.255:8380", "[ff02::1]:8380",
                                 "[::ffff:224.0.0.1]:8380"}) {
    const std::string message =
        "\"listen\" is \"" + many + "\", a multicast or broadcast address: expected an address of this computer";
    expect_mistake("\"[::1]:9000\"", "@\"" + many + "\"\nbehind_proxy = true", message);
    expect_mistake("\"[::1]:9000\"", "\"[::1]:9000\"\n[modbus_server]\nlisten = @\"" + many + "\"", message);
  }
}

TEST(RigFileMistakes, OfTwoListenersOnOnePort) {
  const auto both = [](const std::string& server, const std::string& modbus) {
    return "\"" + server + "\"\n[modbus_server]\nlisten = " + modbus;
  };
  const std::pair<std::string, std::string> colliding[] = {
      {"127.0.0.1:1502", "127.0.0.1:1502"}, {"0.0.0.0:1502", "127.0.0.1:1502"},
      {"127.0.0.1:1502", "0.0.0.0:1502"},   {"localhost:1502", "127.0.0.1:1502"},
      {"[::]:1502", "192.0.2.1:1502"},      {"[::1]:1502", "[::]:1502"},
      {"[::1]:1502", "[0::1]:1502"},        {"[::ffff:127.0.0.1]:1502", "0.0.0.0:1502"}};
  for (const auto& [server, modbus] : colliding)
    expect_mistake(
        "\"[::1]:9000\"", both(server, "@\"" + modbus + "\""),
        "\"listen\" is \"" + modbus + "\", and [server] listens on \"" + server + "\": expected a port of its own");
  const std::pair<std::string, std::string> apart[] = {{"127.0.0.1:8380", "127.0.0.1:1502"},
                                                       {"127.0.0.1:1502", "127.0.0.2:1502"},
                                                       {"0.0.0.0:1502", "[::1]:1502"},
                                                       {"127.0.0.1:0", "127.0.0.1:0"}};
  for (const auto& [server, modbus] : apart) expect_good("\"[::1]:9000\"", both(server, "\"" + modbus + "\""));
}

TEST(RigFileMistakes, OfTheNamesOfTheService) {
  const std::string expected = ": expected host names without a port, for instance [\"bench.local\"]";
  expect_mistake("\"[::1]:9000\"", "\"[::1]:9000\"\nnames = @\"bench\"", "\"names\" is a string" + expected);
  for (const std::string wrong :
       {"\"bench.local:8380\"", "\"\"", "\"127.0.0.1\"", "\"*\"", "\"a..b\"", "\"bench..\"", "\".\""})
    expect_mistake("\"[::1]:9000\"", "\"[::1]:9000\"\nnames = @[\"bench\", " + wrong + "]",
                   "\"names\" holds " + wrong + expected);
  expect_good("\"[::1]:9000\"", "\"[::1]:9000\"\nnames = [\"bench\", \"bench.example.org\"]");
}

TEST(RigFile, ANameOfTheServiceIsTheSameWithTheDotOfTheRoot) {
  std::string text(kGoodRig);
  text.insert(text.find("[recording]"), "names = [\"bench.local.\"]\n");
  const auto file = parse(text, "rig.toml", fake_schemas());
  ASSERT_TRUE(file) << to_string("rig.toml", file.error());
  EXPECT_EQ(file->server.names, std::vector<std::string>{"bench.local"});
}

TEST(RigFileMistakes, OfRecording) {
  expect_mistake("\"runs\"", "@\"\"", "\"directory\" is empty: expected the directory of the recordings, a path");
  expect_mistake("directory = \"runs\"", "@dirctory = \"runs\"",
                 "unknown key \"dirctory\" in [recording]: did you mean \"directory\"?");
  const auto wrong = [](const std::string& with, const std::string& message) {
    expect_mistake("directory = \"runs\"", "directory = \"runs\"\n" + with, message);
  };
  wrong("every = @0", "\"every\" is 0: expected a number from 0.1 to 3600 (s)");
  wrong("retain = @30", "\"retain\" is an integer: expected a table { days, gigabytes }");
  wrong("retain = { days = @0 }", "\"days\" is 0: expected a number above 0, at most 1e6 (days)");
  wrong("retain = { gigabytes = @-1 }", "\"gigabytes\" is -1: expected a number above 0, at most 1e6 (10^9 bytes)");
  wrong("retain = { @weeks = 4 }", "unknown key \"weeks\" in \"retain\": expected days, gigabytes");
  wrong("anchor = @{ minutes = 5 }", "\"anchor\" has neither \"file\" nor \"command\": expected one of them");
  wrong("anchor = { file = \"a\", command = @[\"/bin/cat\"] }",
        "\"anchor\" has a \"file\" and a \"command\": expected one of them");
  wrong("anchor = { minutes = @0.5, file = \"a\" }", "\"minutes\" is 0.5: expected a number from 1 to 10080 (minutes)");
  const std::string command =
      ": expected a program by its whole path and its arguments, for instance [\"/usr/local/bin/send-head\", \"lab\"]";
  wrong("anchor = { command = @\"/bin/cat\" }", "\"command\" is a string" + command);
  wrong("anchor = { command = @[\"cat\"] }", "\"command\" names no program by its whole path" + command);
  wrong("anchor = { command = @[] }", "\"command\" names no program by its whole path" + command);
  wrong("anchor = { command = @[\"/bin/cat\", 3] }", "\"command\" holds 3" + command);
}

TEST(RigFileMistakes, OfGpioLines) {
  expect_mistake("", "[gpio]\nsync = @3\n", "\"sync\" is an integer: expected a table { chip, line, active_low }");
  expect_mistake("", "[gpio]\nsync = @{ chip = \"c\" }\n",
                 "\"sync\" has no \"line\": expected the line's number on its chip, 0 to 65535");
  expect_mistake("", "[gpio]\nsync = @{ line = 1 }\n",
                 "\"sync\" has no \"chip\": expected the chip's device file, for instance \"/dev/gpiochip0\"");
  expect_mistake("", "[gpio]\nsync = { chip = \"c\", line = @-1 }\n",
                 "\"line\" is -1: expected the line's number on its chip, 0 to 65535");
  expect_mistake("", "[gpio]\nsync = { chip = \"c\", line = 1, active_low = @1 }\n",
                 "\"active_low\" is an integer: expected true or false");
  expect_mistake("", "[gpio]\nsync = { chip = \"c\", line = 1, bias = @\"up\" }\n",
                 "\"bias\" is \"up\": expected \"as-is\", \"disabled\", \"pull-up\" or \"pull-down\"");
  expect_mistake("", "[gpio]\nsync = { chip = \"c\", line = 1, debounce = @0.125 }\n",
                 "\"debounce\" is 0.125 and would swallow pulses: expected less than half a period, 0.125 s");
  expect_mistake("", "[gpio]\nready = { chip = \"c\", line = 1, @bias = \"pull-up\" }\n",
                 "unknown key \"bias\" in \"ready\": expected chip, line, active_low");
  expect_mistake("", "[gpio]\nready = { chip = \"c\", line = 1 }\nfault = @{ chip = \"c\", line = 1 }\n",
                 "\"fault\" is the same line as \"ready\": expected a line of its own");
  expect_mistake("", "[gpio]\n@lamp = { chip = \"c\", line = 1 }\n",
                 "unknown key \"lamp\" in [gpio]: expected interlock, sync, ready, fault");
}

TEST(RigFileMistakes, AreToldAllAtOnceInTheOrderOfTheFile) {
  EXPECT_EQ(
      mistakes_in(R"([rig]
name = "bench"
boundary = "clamped"
masses = [12.0, -8.0, 5.0]
wieght = 3

[excitation]
frequency = 4.0
harmonics = 12

[[device]]
name = "amplifier"
driver = "modbsu"

[[channel]]
name = "y0"
measures = "displacement"
at = 0
unit = "N"

[[channel]]
name = "y0"
device = "amplfier"
measures = "displacement"
at = 4
unit = "mm"
)"),
      R"(rig.toml:3:12: the chain is clamped, and no channel measures the force on the ground: expected a channel with measures = "force", at = "ground"
rig.toml:4:11: the motion of mass 1 is given by no combination of transducers: expected a channel at 1, or one across to a place whose motion is given
rig.toml:4:17: mass 2 is -8: expected a number above 0 (kg, or kg*m2 for rotation)
rig.toml:4:17: the motion of mass 2 is given by no combination of transducers: expected a channel at 2, or one across to a place whose motion is given
rig.toml:4:23: the motion of mass 3 is given by no combination of transducers: expected a channel at 3, or one across to a place whose motion is given
rig.toml:5:1: unknown key "wieght" in [rig]: expected name, motion, boundary, masses, mass_u
rig.toml:9:13: "harmonics" is 12: expected an integer from 1 to 8
rig.toml:13:10: driver "modbsu" is not available: expected one of modbus, replay, picky
rig.toml:19:8: "unit" is "N", no unit of displacement in translation: expected one of m, cm, mm, um, nm, in, mil, ft
rig.toml:22:8: two channels are named "y0", the first in line 16: expected a name of its own
rig.toml:23:10: no device is named "amplfier": expected "amplifier"
rig.toml:25:6: "at" is 4, no place of the chain for this channel: expected 0 (the table) to 3 (mass 3)
)");
}

}  // namespace
}  // namespace dwell::config::testing
