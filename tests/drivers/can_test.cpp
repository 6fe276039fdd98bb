// The can plugin as the service sees it: over a local socket that carries what a CAN interface would.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>

#include "config/driver_table.hpp"
#include "daemon/acquire/plugin.hpp"
#include "tests/drivers/can_device.hpp"
#include "tests/drivers/fake_host.hpp"
#include "tests/drivers/given.hpp"

namespace dwell::test {
namespace {

constexpr const char* kDbc =
    "VERSION \"\"\n"
    "BO_ 291 LoadCell: 8 N\n"
    " SG_ Force : 7|16@0- (0.5,-100) [0|0] \"N\" N\n"
    " SG_ Mode M : 16|8@1+ (1,0) [0|0] \"\" N\n"
    " SG_ Early m0 : 24|8@1+ (1,0) [0|0] \"\" N\n"
    " SG_ Late m1 : 24|8@1+ (1,0) [0|0] \"\" N\n"
    " SG_ Serial m2 : 24|96@1+ (1,0) [0|0] \"\" N\n"
    "BO_ 2566844672 Motion: 8 N\n"
    " SG_ Position : 0|32@1- (1,0) [0|0] \"mm\" N\n"
    "BO_ 2566845182 Identity: 20 N\n"
    " SG_ Serial : 0|32@1+ (1,0) [0|0] \"\" N\n"
    "BO_ 1024 Wide: 64 N\n"
    " SG_ Last : 480|32@1- (1,0) [0|0] \"mm\" N\n"
    "BA_DEF_ BO_ \"VFrameFormat\" ENUM \"StandardCAN\",\"ExtendedCAN\",\"reserved\",\"J1939PG\";\n"
    "BA_DEF_DEF_ \"VFrameFormat\" \"StandardCAN\";\n"
    "BA_ \"VFrameFormat\" BO_ 2566844672 3;\n"
    "BA_ \"VFrameFormat\" BO_ 2566845182 3;\n"
    "SIG_VALTYPE_ 1024 Last : 1;\n";

class Can : public ::testing::Test {
 protected:
  Can() : folder_(std::filesystem::temp_directory_path() / ("dwell-can-test-" + std::to_string(::getpid()))) {
    std::filesystem::create_directory(folder_);
    write("rig.dbc", kDbc);
  }
  ~Can() override { std::filesystem::remove_all(folder_); }
  void write(const std::string& name, const std::string& text) { std::ofstream(folder_ / name) << text; }
  Given with_dbc(const std::string& message, const std::string& signal) {
    return std::move(Given("bus", folder_.string())
                         .set("interface", device_.interface())
                         .set("dbc", "rig.dbc")
                         .channel("one")
                         .set("message", message)
                         .set("signal", signal));
  }
  Given by_hand() { return std::move(Given("bus").set("interface", device_.interface()).channel("one")); }
  std::string mistake_of(Given given) {
    const auto mistakes = mistakes_of(table_, *given.settings());
    return mistakes.size() == 1 ? mistakes[0] : std::to_string(mistakes.size()) + " mistakes";
  }
  // The raw numbers that the frames give, in order.
  std::vector<double> measure(Given given, const std::vector<rigsim::WireFrame>& frames, std::size_t expected) {
    device_.come();
    Instance instance(table_, *given.settings(), host_);
    EXPECT_TRUE(instance.exists()) << instance.error();
    if (!instance.exists() || !instance.start() || !device_.await_client()) return {};
    for (const rigsim::WireFrame& frame : frames) device_.send(frame);
    EXPECT_TRUE(eventually([&] { return host_.sample_count() >= expected; }));
    instance.stop();
    std::vector<double> values;
    for (const dwell_sample& sample : host_.samples()) values.push_back(sample.raw);
    return values;
  }

  std::filesystem::path folder_;
  const dwell_driver_table& table_ = *acquire::load_plugin("can", {TEST_PLUGIN_DIR}).value();
  CanDevice device_;
  FakeHost host_;
};

TEST_F(Can, DeliversTheDbcFilesPhysicalValue) {
  EXPECT_EQ(measure(with_dbc("LoadCell", "Force"), {can_frame_of(0x123, {0xFF, 0xFE, 0, 0})}, 1),
            (std::vector<double>{-101.0}));
}

TEST_F(Can, DeliversAMultiplexedSignalFromItsFramesAlone) {
  EXPECT_EQ(measure(with_dbc("LoadCell", "Late"),
                    {can_frame_of(0x123, {0, 0, 0, 5, 0, 0, 0, 0}), can_frame_of(0x123, {0, 0, 1, 6, 0, 0, 0, 0}),
                     can_frame_of(0x123, {0, 0, 2, 7, 0, 0, 0, 0}), can_frame_of(0x123, {0, 0, 1, 8, 0, 0, 0, 0})},
                    2),
            (std::vector<double>{6.0, 8.0}));
}

TEST_F(Can, DeliversAFloatFromTheEndOfAnFdFrame) {
  std::vector<std::uint8_t> data(64);
  const float value = 12.5F;
  std::memcpy(&data[60], &value, sizeof value);
  EXPECT_EQ(measure(with_dbc("Wide", "Last"), {can_frame_of(0x400, data)}, 1), (std::vector<double>{12.5}));
}

TEST_F(Can, MatchesJ1939ByItsParameterGroup) {
  const canid_t id = (2566844672U & CAN_EFF_MASK) | CAN_EFF_FLAG;
  EXPECT_EQ(measure(with_dbc("Motion", "Position"),
                    {can_frame_of(id, {1, 0, 0, 0}), can_frame_of(id | 0x55U, {2, 0, 0, 0}),
                     can_frame_of((id & ~0x1C000000U) | 0x0C000021U, {3, 0, 0, 0})},
                    3),
            (std::vector<double>{1.0, 2.0, 3.0}));
}

TEST_F(Can, NeedsNoDbcFile) {
  Given given = by_hand();
  given.set("id", 0x1ABCDE).set("start", 12).set("length", 12).set("type", "signed");
  EXPECT_EQ(measure(std::move(given), {can_frame_of(0x1ABCDE | CAN_EFF_FLAG, {0, 0xF0, 0xFF})}, 1),
            (std::vector<double>{-1.0}));
}

TEST_F(Can, CountsWhatIsNoFrameAndGoesOn) {
  Given given = by_hand();
  given.set("id", 1).set("start", 0).set("length", 8);
  rigsim::WireFrame long_classic = can_frame_of(1, {1});
  long_classic.can.len = 60;
  EXPECT_EQ(measure(std::move(given), {long_classic, can_frame_of(1, {2})}, 1), (std::vector<double>{2.0}));
  EXPECT_EQ(host_.counted(DWELL_FAULT_BAD_FRAME), 1);
}

TEST_F(Can, HasEveryKeyInTheManual) {
  std::ifstream file(DWELL_RIG_MANUAL);
  const std::string manual{std::istreambuf_iterator<char>(file), {}};
  std::size_t section = 0;
  for (const dwell_scope scope : {DWELL_DEVICE, DWELL_CHANNEL}) {
    section = manual.find(".SS Keys of the driver can\n", section + 1);
    ASSERT_NE(section, std::string::npos);
    const std::string keys = manual.substr(section, manual.find("\n.S", section + 1) - section);
    for (const dwell_key& key : config::keys_of(table_))
      EXPECT_EQ(keys.find("\n.B " + std::string(key.name) + "\n") != std::string::npos, key.scope == scope) << key.name;
  }
}

TEST_F(Can, AnswersAMistakeOfTheDbcFileWithItsPlace) {
  write("rig.dbc", "BO_ 291 LoadCell: 8 N\n SG_ Force : 7|16@0- (0.5;-100) [0|0] \"N\" N\nBO_ x\n");
  Given given = with_dbc("LoadCell", "Force");
  const auto mistakes = mistakes_of(table_, *given.settings());
  ASSERT_EQ(mistakes.size(), 2U);
  EXPECT_EQ(mistakes[0], "device, dbc: rig.dbc:2:26: found `;`; expected `,` after the signal's factor");
  EXPECT_EQ(mistakes[1],
            "device, dbc: rig.dbc:3:5: found `x`; expected the message's identifier, a whole number up to 4294967295");
}

TEST_F(Can, AnswersANameTheDbcFileLacksWithTheNearest) {
  EXPECT_EQ(mistake_of(with_dbc("LoadCel", "Force")),
            "channel 0, message: rig.dbc has no message `LoadCel`; the nearest is LoadCell");
  EXPECT_EQ(mistake_of(with_dbc("LoadCell", "force")),
            "channel 0, signal: message `LoadCell` of rig.dbc has no signal `force`; the nearest is Force");
  EXPECT_EQ(mistake_of(with_dbc("Qqqqqqqq", "Force")),
            "channel 0, message: rig.dbc has no message `Qqqqqqqq`; expected one of LoadCell, Motion, Identity, Wide");
}

TEST_F(Can, AnswersANameThatMayBeSeveralMessages) {
  const std::string signal = ": 8 N\n SG_ S : 0|8@1+ (1,0) [0|0] \"\" N\n";
  const std::string format =
      "BA_DEF_ BO_ \"VFrameFormat\" ENUM \"StandardCAN\",\"ExtendedCAN\",\"reserved\",\"J1939PG\";\n"
      "BA_DEF_DEF_ \"VFrameFormat\" \"J1939PG\";\n";
  write("rig.dbc",
        "BO_ 1 A" + signal + "BO_ 2 A" + signal + "BO_ 2566869025 B" + signal + "BO_ 2566869026 C" + signal + format);
  EXPECT_EQ(mistake_of(with_dbc("A", "S")),
            "channel 0, message: rig.dbc has several messages `A`; expected a name of its own");
  EXPECT_EQ(
      mistake_of(with_dbc("C", "S")),
      "channel 0, message: message `C` of rig.dbc has the parameter group of `B`; expected `source` to say whose it "
      "is: 34 in the file");
  Given said = with_dbc("C", "S");
  said.set("source", 34);
  EXPECT_TRUE(mistakes_of(table_, *said.settings()).empty());
}

TEST_F(Can, AnswersASignalItCannotReadWithItsPlace) {
  EXPECT_EQ(mistake_of(with_dbc("LoadCell", "Serial")),
            "channel 0, signal: rig.dbc:7:6: signal `Serial` is of 96 bits; expected at most 64");
}

TEST_F(Can, AnswersAGroupThatComesInSeveralFrames) {
  EXPECT_EQ(
      mistake_of(with_dbc("Identity", "Serial")),
      "channel 0, message: message `Identity` of rig.dbc has 20 bytes, which J1939 sends in several frames; expected "
      "at most 8");
}

TEST_F(Can, AnswersWhatDoesNotGoTogether) {
  EXPECT_EQ(mistake_of(by_hand()),
            "channel 0, : nothing says where the reading is; expected `message` and `signal`, or `id`, `start` and "
            "`length`");
  Given given = by_hand();
  given.set("id", 0x800).set("extended", false).set("start", 0).set("length", 8);
  EXPECT_EQ(mistake_of(std::move(given)),
            "channel 0, id: identifier 0x800 has more than 11 bits; expected at most 0x7FF, or extended = true");
  given = by_hand();
  given.set("id", 1).set("start", 0).set("length", 16).set("type", "float");
  EXPECT_EQ(mistake_of(std::move(given)), "channel 0, length: a float of 16 bits; expected 32 or 64");
  given = by_hand();
  given.set("id", 1).set("start", 511).set("length", 2);
  EXPECT_EQ(mistake_of(std::move(given)), "channel 0, start: the signal ends in byte 65; expected it within 64");
  given = by_hand();
  given.set("id", 1).set("start", 0).set("length", 8).set("source", 3);
  EXPECT_EQ(mistake_of(std::move(given)),
            "channel 0, source: only J1939 messages have a source address; expected `pgn`, or a J1939 message of the "
            "DBC file");
  given = by_hand();
  given.set("message", "LoadCell").set("signal", "Force");
  EXPECT_EQ(mistake_of(std::move(given)),
            "channel 0, message: a message by name needs a DBC file; expected `dbc` in the device's table");
  given = by_hand();
  given.set("id", 1).set("start", 0);
  EXPECT_EQ(mistake_of(std::move(given)), "channel 0, id: `length` is missing; expected it beside the identifier");
  given = with_dbc("LoadCell", "Force");
  given.set("id", 1);
  EXPECT_EQ(mistake_of(std::move(given)),
            "channel 0, message: `message` and `id` are two ways to say where the reading is; expected one of them");
  given = with_dbc("LoadCell", "Force");
  given.set_device("interface", "no such interface at all");
  EXPECT_EQ(mistakes_of(table_, *given.settings()).size(), 1U);
}

}  // namespace
}  // namespace dwell::test
