#include "drivers/can/dbc.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace dwell::can {
namespace {

// As tools write them: sections nobody needs, texts over several lines, a signal in each form.
constexpr const char* kReal = R"(VERSION "1.0"

NS_ :
	NS_DESC_
	CM_
	BA_DEF_
	BA_
	VAL_
	SG_MUL_VAL_

BS_:

BU_: ECU Logger
VAL_TABLE_ States 1 "on" 0 "off" ;

BO_ 291 LoadCell: 8 ECU
 SG_ Force : 0|32@1- (0.1,-5) [-1e6|1e6] "N" Logger,ECU
 SG_ Temperature : 39|12@0+ (1,0) [0|0] "°C" Vector__XXX

BO_ 2566834709 Engine: 8 Vector__XXX
 SG_ Mode M : 0|8@1+ (1,0) [0|255] "" Logger
 SG_ A m0 : 8|16@1+ (1,0) [0|0] "" Logger
 SG_ B m1 : 8|16@1- (1,0) [0|0] "" Logger
BO_ 3221225472 VECTOR__INDEPENDENT_SIG_MSG: 0 Vector__XXX
 SG_ Orphan : 0|8@1+ (1,0) [0|0] "" Vector__XXX

BO_ 512 Wide: 64 ECU
 SG_ Float : 0|32@1- (1,0) [0|0] "" ECU
 SG_ Double : 448|64@1- (1,0) [0|0] "" ECU

BO_TX_BU_ 291 : ECU,Logger;
EV_ Env: 0 [0|1] "" 0 1 DUMMY_NODE_VECTOR0 Vector__XXX;
CM_ "a comment
BO_ 1 that speaks of one; and has a \"quote\"";
CM_ SG_ 291 Force "x";
BA_DEF_ BO_ "VFrameFormat" ENUM "StandardCAN","ExtendedCAN","reserved","J1939PG";
BA_DEF_ BO_ "GenMsgCycleTime" INT 0 10000;
BA_DEF_DEF_ "VFrameFormat" "StandardCAN";
BA_ "GenMsgCycleTime" BO_ 291 20;
BA_ "VFrameFormat" BO_ 2566834709 3;
VAL_ 291 Force 1 "one" 0 "zero" ;
SIG_VALTYPE_ 512 Float : 1;
SIG_VALTYPE_ 512 Double : 2;
SOME_FUTURE_SECTION_ 1 2 "x";
)";

const Message& message(const Dbc& dbc, std::string_view name) {
  return *std::find_if(dbc.messages.begin(), dbc.messages.end(), [&](const Message& m) { return m.name == name; });
}
const Signal& signal(const Message& message, std::string_view name) {
  return *std::find_if(message.signals.begin(), message.signals.end(), [&](const Signal& s) { return s.name == name; });
}

// The mistakes of a text, "LINE:COLUMN: …".
std::vector<std::string> mistakes(const std::string& text) {
  std::vector<std::string> lines;
  if (const DbcResult result = parse_dbc(text); !result)
    for (const DbcMistake& each : result.error()) lines.push_back(to_string("f", each));
  return lines;
}
std::string mistake(const std::string& text) {
  const auto all = mistakes(text);
  return all.size() == 1 ? all[0] : std::to_string(all.size()) + " mistakes";
}

TEST(Dbc, ReadsWhatToolsWrite) {
  const DbcResult result = parse_dbc(kReal);
  ASSERT_TRUE(result) << to_string("", result.error()[0]);
  ASSERT_EQ(result->messages.size(), 3U);
  const Message& cell = message(*result, "LoadCell");
  EXPECT_EQ(cell.id, 291U);
  EXPECT_FALSE(cell.extended);
  EXPECT_FALSE(cell.j1939);
  EXPECT_DOUBLE_EQ(cell.cycle_s, 0.02);
  const Signal& force = signal(cell, "Force");
  EXPECT_EQ(force.field.form, Form::signed_integer);
  EXPECT_EQ(force.field.order, Order::intel);
  EXPECT_EQ(force.factor, 0.1);
  EXPECT_EQ(force.offset, -5.0);
  const Signal& temperature = signal(cell, "Temperature");
  EXPECT_EQ(temperature.field.order, Order::motorola);
  EXPECT_EQ(temperature.field.start, 39);
  EXPECT_EQ(temperature.field.length, 12);
  const Message& wide = message(*result, "Wide");
  EXPECT_EQ(signal(wide, "Float").field.form, Form::float32);
  EXPECT_EQ(signal(wide, "Double").field.form, Form::float64);
}

TEST(Dbc, TakesBit31ForTheExtendedFlagAndTheFormatAttributeForJ1939) {
  const Dbc dbc = *parse_dbc(kReal);
  const Message& engine = message(dbc, "Engine");
  EXPECT_EQ(engine.id, 2566834709U & 0x1FFFFFFFU);
  EXPECT_TRUE(engine.extended);
  EXPECT_TRUE(engine.j1939);
}

TEST(Dbc, JoinsMultiplexedSignalsToTheirMultiplexor) {
  const Dbc dbc = *parse_dbc(kReal);
  const Message& engine = message(dbc, "Engine");
  const Signal& b = signal(engine, "B");
  EXPECT_TRUE(b.multiplexed);
  EXPECT_EQ(engine.signals[b.selector].name, "Mode");
  ASSERT_EQ(b.selected_by.size(), 1U);
  EXPECT_EQ(b.selected_by[0], std::pair(std::uint64_t{1}, std::uint64_t{1}));
}

TEST(Dbc, ReadsMultiplexorsOfMultiplexors) {
  const DbcResult result = parse_dbc(
      "BO_ 1 X: 8 N\n"
      " SG_ Outer M : 0|4@1+ (1,0) [0|0] \"\" N\n"
      " SG_ Inner m1M : 4|4@1+ (1,0) [0|0] \"\" N\n"
      " SG_ Value m2 : 8|8@1+ (1,0) [0|0] \"\" N\n"
      "SG_MUL_VAL_ 1 Inner Outer 1-1, 3-5;\n"
      "SG_MUL_VAL_ 1 Value Inner 2-2;\n");
  ASSERT_TRUE(result) << to_string("", result.error()[0]);
  const Message& x = result->messages[0];
  EXPECT_EQ(x.signals[2].selector, 1U);
  EXPECT_EQ(x.signals[1].selector, 0U);
  EXPECT_EQ(x.signals[1].selected_by, (std::vector<std::pair<std::uint64_t, std::uint64_t>>{{1, 1}, {3, 5}}));
}

TEST(Dbc, SaysWhereAndWhatIsWrong) {
  EXPECT_EQ(mistake("BO_ 100 A: 8 N\n SG_ S : 0|8@3+ (1,0) [0|0] \"\" N\n"),
            "f:2:14: found `3`; expected the order of bytes: 0 Motorola, 1 Intel, a whole number up to 1");
  EXPECT_EQ(mistake("BO_ 0x10 A: 8 N\n"),
            "f:1:5: found `0x10`; expected the message's identifier, a whole number up to 4294967295");
  EXPECT_EQ(mistake("BO_ 100 A 8 N\n"), "f:1:11: found `8`; expected `:` after the message's name");
  EXPECT_EQ(mistake("BO_ 4096 A: 8 N\n"),
            "f:1:5: identifier 4096 has more than 11 bits; expected an extended one to have bit 31 set");
  EXPECT_EQ(mistake("BO_ 1 A: 8 N\nBO_ 1 B: 8 N\n"),
            "f:2:5: identifier 1 is that of message `A` already; expected one of its own");
  EXPECT_EQ(mistake("BO_ 1 A: 2 N\n SG_ S : 9|8@1+ (1,0) [0|0] \"\" N\n"),
            "f:2:6: signal `S` needs 3 bytes; expected it within the 2 of message `A`");
  EXPECT_EQ(mistake("BO_ 1 A: 8 N\n SG_ S m1 : 9|8@1+ (1,0) [0|0] \"\" N\n"),
            "f:2:6: signal `S` is multiplexed, but its message has no multiplexor; expected one with M");
  EXPECT_EQ(mistake("BO_ 1 A: 8 N\n SG_ S : 0|8@1+ (nan,0) [0|0] \"\" N\n"),
            "f:2:18: found `nan`; expected the signal's factor, a number");
  EXPECT_EQ(mistake("CM_ \"has no end;\nBO_ 1 A: 8 N\n"),
            "f:1:5: the text that begins here has no end; expected a quote");
  EXPECT_EQ(mistake("VAL_ 1 S 0 \"x\"\nBO_ 1 A: 8 N\n"), "f:1:1: `VAL_` has no end; expected `;` before line 2");
  EXPECT_EQ(mistake("<xml>\n"), "f:1:1: found `<`; expected the next section, for instance BO_");
  EXPECT_EQ(mistake("SG_ S : 0|8@1+ (1,0) [0|0] \"\" N\n"),
            "f:1:1: a signal outside of a message; expected BO_ before it");
  EXPECT_EQ(mistake("BO_ 1 A: 8 N\n SG_ S : 0|16@1+ (1,0) [0|0] \"\" N\nSIG_VALTYPE_ 1 S : 1;\n"),
            "f:3:16: signal `S` has 16 bits; expected a float of 32 to have as many");
  EXPECT_EQ(mistake("BO_ 1 A: 8 N\nSIG_VALTYPE_ 1 T : 1;\n"),
            "f:2:16: message `A` has no signal `T`; expected one of its SG_");
  EXPECT_EQ(mistake("SIG_VALTYPE_ 1 T : 1;\n"), "f:1:14: no message has the identifier 1; expected one of BO_");
}

TEST(Dbc, AMissingQuoteSwallowsNothing) {
  const auto all = mistakes(
      "BO_ 1 A: 8 N\n SG_ S : 0|8@1+ (1,0) [0|0] \"mm N\n SG_ T : 8|8@1+ (1,0) [0|0] \" N\n\n"
      "BO_ 2 B: 4 N\n SG_ U : 0|32@1- (0,0) [0|0] \"mm\" N\nSIG_VALTYPE_ 2 U : 1;\n");
  ASSERT_EQ(all.size(), 3U);
  EXPECT_EQ(all[0], "f:2:29: the text that begins here has no end on its line; expected a quote");
  EXPECT_EQ(all[1].substr(0, 7), "f:3:29:");
  EXPECT_EQ(all[2], "f:6:19: a factor of 0 makes every reading the same; expected another");
}

TEST(Dbc, AVersionWithoutItsEndSwallowsNothing) {
  for (const auto& [version, at] : {std::pair("VERSION \"1.0\n\n", "1:9"), std::pair("VERSION\n\"1.0\n", "2:1")}) {
    const auto all = mistakes(std::string(version) + "BO_ 1 A: 8 N\n SG_ S : 0|8@1+ (0,0) [0|0] \"mm\" N\n");
    ASSERT_EQ(all.size(), 2U);
    EXPECT_EQ(all[0], "f:" + std::string(at) + ": the text that begins here has no end on its line; expected a quote");
    EXPECT_EQ(all[1], "f:4:18: a factor of 0 makes every reading the same; expected another");
  }
}

// Each would be read to the end of the file, if nothing were said of it.
TEST(Dbc, GivesUpAfterTwentyLinesWhoseTextsHaveNoEnd) {
  for (const std::string line : {"BS_\\\"\n", "BO_ 3221225472 X: 0 N \\\"\n"}) {
    std::string text;
    while (text.size() < (1U << 20U)) text += line;
    const auto all = mistakes(text);
    ASSERT_EQ(all.size(), kMostMistakes);
    const std::string column = std::to_string(line.size() - 1);
    for (std::size_t i = 0; i < all.size(); ++i)
      EXPECT_EQ(all[i], "f:" + std::to_string(i + 1) + ":" + column +
                            ": the text that begins here has no end on its line; expected a quote");
  }
}

TEST(Dbc, RefusesASelectionThatNeverComesOrIsTwo) {
  const std::string two = "BO_ 1 X: 8 N\n SG_ M M : 0|4@1+ (1,0) [0|0] \"\" N\n SG_ L M : 4|4@1+ (1,0) [0|0] \"\" N\n";
  EXPECT_EQ(mistake("BO_ 1 X: 8 N\n SG_ M M : 0|4@1+ (1,0) [0|0] \"\" N\n SG_ A m16 : 8|8@1+ (1,0) [0|0] \"\" N\n"),
            "f:3:6: signal `A` is selected by 16, but `M` has 4 bits; expected at most 15");
  EXPECT_EQ(mistake(two + " SG_ A m1 : 8|8@1+ (1,0) [0|0] \"\" N\nSG_MUL_VAL_ 1 A M 1-1;\nSG_MUL_VAL_ 1 A L 1-1;\n"),
            "f:6:17: signal `A` is selected by `M` already; expected one multiplexor");
  EXPECT_EQ(mistake("BO_ 1 X: 16 N\n SG_ M M : 0|65@1+ (1,0) [0|0] \"\" N\n SG_ A m1 : 72|8@1+ (1,0) [0|0] \"\" N\n"),
            "f:3:6: signal `A` is multiplexed by `M`, which is of 65 bits; expected at most 64");
  EXPECT_EQ(mistake("BO_ 2147483649 X: 100 N\n SG_ M M : 600|8@1+ (1,0) [0|0] \"\" N\n"
                    " SG_ A m1 : 0|8@1+ (1,0) [0|0] \"\" N\n"),
            "f:3:6: signal `A` is multiplexed by `M`, which lies beyond the 64 bytes that one frame has");
}

TEST(Dbc, TellsEveryMistakeAtOnceInOrder) {
  const auto all = mistakes(
      "BO_ 1 A: 8 N\n SG_ S : 0|8@1* (1,0) [0|0] \"\" N\n SG_ T : 0|8@1+ (1,0) [0|0] \"\" N\n"
      " SG_ U : x|8@1+ (1,0) [0|0] \"\" N\nBO_ B: 8 N\n SG_ V : x\n");
  ASSERT_EQ(all.size(), 3U);
  EXPECT_EQ(all[0].substr(0, 6), "f:2:15");
  EXPECT_EQ(all[1].substr(0, 6), "f:4:10");
  EXPECT_EQ(all[2].substr(0, 5), "f:5:5");
}

TEST(Dbc, RefusesAMultiplexorThatSelectsItself) {
  EXPECT_EQ(mistakes("BO_ 1 X: 8 N\n"
                     " SG_ A m0M : 0|4@1+ (1,0) [0|0] \"\" N\n"
                     " SG_ B m0M : 4|4@1+ (1,0) [0|0] \"\" N\n"
                     "SG_MUL_VAL_ 1 A B 0-0;\nSG_MUL_VAL_ 1 B A 0-0;\n")
                .size(),
            2U);
}

TEST(Dbc, KeepsASignalItCannotReadForWhoeverDoesNotWantIt) {
  const DbcResult result = parse_dbc("BO_ 2147483649 A: 20 N\n SG_ Vin : 0|136@1+ (1,0) [0|0] \"\" N\n");
  ASSERT_TRUE(result);
  EXPECT_EQ(result->messages[0].signals[0].unreadable, "is of 136 bits; expected at most 64");
}

TEST(Dbc, StopsAfterTwentyMistakes) {
  std::string text;
  for (int i = 0; i < 1000; ++i) text += "BO_ x\n";
  EXPECT_EQ(mistakes(text).size(), kMostMistakes);
}

TEST(Dbc, SaysWhyAFileCannotBeRead) {
  EXPECT_EQ(to_string("f", read_dbc("/nonexistent.dbc").error()[0]),
            "f:1:1: cannot be read: No such file or directory");
  EXPECT_EQ(to_string("f", read_dbc("/tmp").error()[0]), "f:1:1: is not a file");
}

TEST(Dbc, KnowsTheNearestNames) {
  EXPECT_EQ(nearest("force", {"Temperature", "Force", "Forces", "X"}), (std::vector<std::string>{"Force", "Forces"}));
  EXPECT_TRUE(nearest("Zzzz", {"Temperature"}).empty());
}

}  // namespace
}  // namespace dwell::can
