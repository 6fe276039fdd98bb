// Mistakes in [[channel]], and what the channels together do not give. "@" marks where each is expected to be reported.
#include <gtest/gtest.h>

#include "tests/config/fake_drivers.hpp"

namespace dwell::config::testing {
namespace {

TEST(ChannelMistakes, OfNames) {
  const std::string expected =
      ": expected printable text without commas and quotes, at most 64 bytes, not t, channel or value";
  for (const char* wrong : {"t", "channel", "value", "a,b", " y0", "y0 "}) {
    expect_mistake("\"y0\"", "@\"" + std::string(wrong) + "\"",
                   "\"name\" is \"" + std::string(wrong) + "\"" + expected);
  }
  expect_mistake("\"y0\"", "@'a\"b'", "\"name\" is \"a\"b\"" + expected);
  expect_mistake("\"y0\"", "@\"\"", "\"name\" is empty" + expected);
  expect_mistake("\"y0\"", "@\"a\\tb\"", "\"name\" holds control characters or is too long" + expected);
  expect_mistake("\"y0\"", "@\"a\\u0085b\"", "\"name\" holds control characters or is too long" + expected);
  expect_mistake("\"y0\"", "@\"a\\u202Eb\"", "\"name\" holds control characters or is too long" + expected);
  expect_mistake("\"y0\"", "@\"a\\u2028b\"", "\"name\" holds control characters or is too long" + expected);
  expect_mistake("\"y0\"", "@\"" + std::string(65, 'y') + "\"",
                 "\"name\" is \"" + std::string(60, 'y') + "...\"" + expected);
  expect_good("\"y0\"", "\"Tischweg °1\"");
}

TEST(ChannelMistakes, OfTwoWithOneName) {
  expect_mistake("\"a1\"", "@\"y0\"",
                 "two channels are named \"y0\", the first in line 46: expected a name of its own");
}

TEST(ChannelMistakes, OfPlacesTheChainDoesNotHave) {
  const std::string expected = ", no place of the chain for this channel: expected 0 (the table) to 2 (mass 2)";
  const std::string unseen =
      "the motion of the table is given by no combination of transducers: expected a channel at 0, or one across to a "
      "place whose motion is given";
  // The channel of the table is then missing as well, which is a mistake of its own.
  for (const char* wrong : {"3", "-1", "\"ground\"", "\"top\""}) {
    const Edited edit = edited("at = 0", "at = @" + std::string(wrong));
    std::string told = "rig.toml:5:10: ";
    told.append(unseen).append("\nrig.toml:49:6: \"at\" is ").append(wrong).append(expected).append("\n");
    EXPECT_EQ(mistakes_in(edit.text), told);
  }
  const Edited fraction = edited("at = 0", "at = @0.0");
  EXPECT_EQ(mistakes_in(fraction.text),
            "rig.toml:5:10: " + unseen +
                "\nrig.toml:49:6: \"at\" is a number with a fraction: expected 0 (the table) "
                "to 2 (mass 2)\n");
}

TEST(ChannelMistakes, OfRelativePlaces) {
  const std::string unseen =
      "rig.toml:5:17: the motion of mass 2 is given by no combination of transducers: expected a channel at 2, or one "
      "across to a place whose motion is given\n";
  EXPECT_EQ(mistakes_in(edited("relative_to = 1", "relative_to = 2").text),
            unseen + "rig.toml:77:15: \"relative_to\" is 2 like \"at\": expected another place of the chain\n");
  EXPECT_EQ(mistakes_in(edited("relative_to = 1", "relative_to = 9").text),
            unseen +
                "rig.toml:77:15: \"relative_to\" is 9, no place of the chain for this channel: expected 0 (the table) "
                "to 2 (mass 2) or \"ground\"\n");
  expect_mistake("positive = \"mass\"", "relative_to = @1",
                 "\"relative_to\" goes with a motion: expected none with a force");
}

TEST(ChannelMistakes, OfMotionsThatNoCombinationOfTransducersGives) {
  const std::string tail = ": expected a channel at 1, or one across to a place whose motion is given\n";
  // The accelerometer on mass 1 gone, the transducer across element 2 hangs in the air.
  EXPECT_EQ(
      mistakes_in(edited("measures = \"acceleration\"\nat = 1\nunit = \"g\"", "measures = \"auxiliary\"\nat = 1").text),
      "rig.toml:5:11: the motion of mass 1 is given by no combination of transducers" + tail +
          "rig.toml:5:17: the motion of mass 2 is given by no combination of transducers: expected a channel at 2, or "
          "one across to a place whose motion is given\n");
  expect_good("relative_to = 1", "relative_to = 0");
  expect_good("relative_to = 1", "relative_to = \"ground\"");
}

TEST(ChannelMistakes, OfForces) {
  expect_mistake("measures = \"force\"\nat = \"ground\"\npositive = \"mass\"\nunit = \"kN\"",
                 "measures = \"force\"\nat = @2\npositive = \"mass\"\nunit = \"kN\"",
                 "\"at\" is 2: expected \"ground\", where a force is measured");
  expect_mistake("[[channel]]\nname = \"reaction\"\ndevice = \"bus\"\nmeasures = \"force\"\nat = \"ground\"",
                 "@[[channel]]\nname = \"reaction\"\ndevice = \"bus\"\nmeasures = \"force\"",
                 "[[channel]] has no \"at\": expected \"ground\", where a force is measured");
  expect_mistake("positive = \"mass\"", "positive = @\"up\"",
                 "\"positive\" is \"up\": expected \"ground\" or \"mass\"");
  expect_mistake("scale = -2.0", "positive = @\"ground\"",
                 "\"positive\" goes with a force: expected none with \"displacement\"");
}

TEST(ChannelMistakes, OfAClampedChainWithoutAForce) {
  const Edited edit =
      edited("measures = \"force\"\nat = \"ground\"\npositive = \"mass\"\n", "measures = \"auxiliary\"\n");
  EXPECT_EQ(
      mistakes_in(edit.text),
      "rig.toml:4:12: the chain is clamped, and no channel measures the force on the ground: expected a channel with "
      "measures = \"force\", at = \"ground\"\n");
}

TEST(ChannelMistakes, OfAFreeChainWithAForce) {
  const Edited edit = edited("\"clamped\"", "\"free\"");
  EXPECT_EQ(
      mistakes_in(edit.text),
      "rig.toml:85:12: a force is measured on a free chain, which has no element to the ground: expected boundary "
      "\"clamped\", or \"auxiliary\"\n");
}

TEST(ChannelMistakes, OfAFreeChainWithNothingOrMeasuredAgainstTheGround) {
  EXPECT_EQ(
      mistakes_in("[rig]\nname='a'\nboundary='free'\nmasses=[]\n[excitation]\nfrequency=4\n[[channel]]\nname='y'\n"
                  "measures='displacement'\nat=0\nunit='m'\n",
                  nullptr),
      "rig.toml:4:8: a free chain has no masses: expected at least one (none goes with \"clamped\")\n");
  EXPECT_EQ(
      mistakes_in("[rig]\nname='a'\nboundary='free'\nmasses=[1]\n[excitation]\nfrequency=4\n[[channel]]\nname='y'\n"
                  "measures='displacement'\nat=0\nrelative_to='ground'\nunit='m'\n[[channel]]\nname='z'\n"
                  "measures='displacement'\nat=1\nunit='m'\n[[channel]]\nname='x'\n"
                  "measures='displacement'\nat=0\nunit='m'\n",
                  nullptr),
      "rig.toml:11:13: \"relative_to\" is \"ground\", no place of the chain for this channel: expected 0 (the table) "
      "to 1 (mass 1)\n");
}

TEST(ChannelMistakes, OfQuantityAndUnit) {
  expect_mistake("measures = \"acceleration\"", "measures = @\"accel\"",
                 "\"measures\" is \"accel\": expected \"displacement\", \"velocity\", \"acceleration\", \"force\" or "
                 "\"auxiliary\"");
  expect_mistake(
      "\"g\"", "@\"mm\"",
      "\"unit\" is \"mm\", no unit of acceleration in translation: expected one of m/s2, cm/s2, mm/s2, um/s2, "
      "in/s2, ft/s2, g, mg");
  expect_mistake(
      "\"kN\"", "@\"N*m\"",
      "\"unit\" is \"N*m\", no unit of force in translation: expected one of N, mN, kN, MN, lbf, ozf, kip, kgf");
  expect_mistake(
      "[[channel]]\nname = \"a1\"\ndevice = \"amplifier\"\nmeasures = \"acceleration\"\nat = 1\nunit = \"g\"",
      "@[[channel]]\nname = \"a1\"\ndevice = \"amplifier\"\nmeasures = \"acceleration\"\nat = 1",
      "[[channel]] has no \"unit\": expected one of m/s2, cm/s2, mm/s2, um/s2, in/s2, ft/s2, g, mg");
  const Edited rotation = edited("\"translation\"", "\"rotation\"");
  EXPECT_EQ(
      mistakes_in(rotation.text),
      "rig.toml:50:8: \"unit\" is \"mm\", no unit of displacement in rotation: expected one of rad, mrad, urad, deg, "
      "rev\n"
      "rig.toml:68:8: \"unit\" is \"g\", no unit of acceleration in rotation: expected one of rad/s2, mrad/s2, deg/s2, "
      "rev/s2\n"
      "rig.toml:78:8: \"unit\" is \"in\", no unit of displacement in rotation: expected one of rad, mrad, urad, deg, "
      "rev\n"
      "rig.toml:88:8: \"unit\" is \"kN\", no unit of force in rotation: expected one of N*m, mN*m, kN*m, MN*m, N*cm, "
      "N*mm, lbf*in, lbf*ft, ozf*in, kgf*m\n");
}

TEST(ChannelMistakes, OfConversion) {
  expect_mistake("scale = -2.0", "scale = @0.0", "\"scale\" is 0: expected a number other than 0");
  expect_mistake("scale = -2.0", "scale = @nan", "\"scale\" is nan: expected a number other than 0");
  expect_mistake("scale = -2.0", "scale = @\"2\"", "\"scale\" is a string: expected a number other than 0");
  expect_mistake("offset = 0.5", "offset = @inf", "\"offset\" is inf: expected a number, in the channel's unit");
  expect_mistake("scale_u = 0.001", "scale_u = @-0.1",
                 "\"scale_u\" is -0.1: expected a number from 0, below 1 (relative)");
  expect_mistake("scale_u = 0.001", "scale_u = @1", "\"scale_u\" is 1: expected a number from 0, below 1 (relative)");
  expect_mistake("delay = 0.0004", "delay = @11", "\"delay\" is 11: expected a number from -10 to 10 (s)");
  expect_mistake("delay_u = 2e-5", "delay_u = @-1", "\"delay_u\" is -1: expected a number from 0 to 10 (s)");
}

TEST(ChannelMistakes, OfRanges) {
  const std::string expected = ": expected [low, high] in the channel's unit, low < high";
  expect_mistake("[-10.0, 10.0]", "@[10, -10]", "\"range\" is [10, -10]" + expected);
  expect_mistake("[-10.0, 10.0]", "@[1, 1]", "\"range\" is [1, 1]" + expected);
  for (const std::string wrong : {"[nan, 1]", "[-inf, 1]"})
    expect_mistake(
        "[-10.0, 10.0]", "@" + wrong,
        "\"range\" is " + wrong + ": expected two finite numbers, [low, high] in the channel's unit, low < high");
  for (const char* wrong : {"@[1]", "@[1, 2, 3]", "@[\"a\", \"b\"]"}) {
    expect_mistake("[-10.0, 10.0]", wrong, "\"range\" is not two numbers" + expected);
  }
  expect_mistake("[-10.0, 10.0]", "@10", "\"range\" is an integer" + expected);
}

TEST(ChannelMistakes, OfFilters) {
  constexpr std::string_view filter = "{ type = \"butterworth\", order = 2, hz = 250, hz_u = 5.0 }";
  const std::string types = ": expected \"butterworth\", \"bessel\" or \"rc\"";
  expect_mistake(filter, "@{ order = 2, hz = 250 }", "\"lowpass\" has no \"type\"" + types);
  expect_mistake(filter, "{ type = @\"chebyshev\", order = 2, hz = 250 }", "\"type\" is \"chebyshev\"" + types);
  expect_mistake(filter, "@{ type = \"rc\", hz = 250 }",
                 "\"lowpass\" has no \"order\": expected an integer from 1 to 8");
  expect_mistake(filter, "{ type = \"rc\", order = @0, hz = 250 }", "\"order\" is 0: expected an integer from 1 to 8");
  expect_mistake(filter, "{ type = \"rc\", order = @9, hz = 250 }", "\"order\" is 9: expected an integer from 1 to 8");
  expect_mistake(filter, "@{ type = \"rc\", order = 2 }",
                 "\"lowpass\" has no \"hz\": expected the corner, above 0, at most 1e9 (Hz)");
  expect_mistake(filter, "{ type = \"rc\", order = 2, hz = @0 }",
                 "\"hz\" is 0: expected the corner, above 0, at most 1e9 (Hz)");
  expect_mistake(filter, "{ type = \"rc\", order = 2, hz = 250, hz_u = @-1 }",
                 "\"hz_u\" is -1: expected a number 0 or more (Hz)");
  expect_mistake(filter, "{ type = \"rc\", order = 2, hz = 250, hz_u = @250 }",
                 "\"hz_u\" is 250: expected less than the corner itself, 250 Hz");
  expect_mistake(filter, "{ type = \"rc\", order = 2, hz = 250, @corner = 2 }",
                 "unknown key \"corner\" in \"lowpass\": expected type, order, hz, hz_u");
  expect_mistake(filter, "@250", "\"lowpass\" is an integer: expected a table { type, order, hz }");
  expect_mistake(
      "highpass = { type = \"rc\", order = 1, hz = 0.5 }", "highpass = @{ type = \"rc\", order = 1, hz = 300 }",
      "the corner of \"highpass\" is not below that of \"lowpass\", so that nothing passes: expected less than 250 "
      "Hz");
}

TEST(ChannelMistakes, OfCalibration) {
  constexpr std::string_view calibration = "{ id = \"K-2231\", due = 2027-03-31 }";
  const std::string date = ": expected a date without quotes, for instance 2027-03-31";
  expect_mistake(calibration, "{ id = \"K\", due = @\"2027-03-31\" }", "\"due\" is a string" + date);
  expect_mistake(calibration, "{ id = \"K\", due = @2027-03-31T00:00:00Z }", "\"due\" is a date with a time" + date);
  expect_mistake(calibration, "{ id = @2231 }", "\"id\" is an integer: expected the number of the certificate, text");
  expect_mistake(calibration, "@{ due = 2027-03-31 }",
                 "\"calibration\" has no \"id\": expected the number of the certificate, text");
  expect_good(calibration, "{ id = \"K\" }");
}

TEST(ChannelMistakes, OfMisspeltKeysShowEvenWhereTheDriverIsNotAsked) {
  expect_mistake("scale = -2.0", "@scal = -2.0", "unknown key \"scal\" in [[channel]]: did you mean \"scale\"?",
                 nullptr);
  expect_mistake("offset = 0.5", "@ofset = 0.5", "unknown key \"ofset\" in [[channel]]: did you mean \"offset\"?",
                 nullptr);
  expect_good("offset = 0.5", "something = 0.5", nullptr);
}

TEST(ChannelMistakes, OfTooManyAreOneMistake) {
  std::string text = "[rig]\nname = \"a\"\nboundary = \"clamped\"\nmasses = []\n[excitation]\nfrequency = 4\n";
  for (std::size_t i = 0; i < kMaxChannels + 1; ++i) text += "[[channel]]\n";
  EXPECT_EQ(mistakes_in(text, nullptr), "rig.toml:7:1: 65536 channels: expected at most 65535\n");
}

}  // namespace
}  // namespace dwell::config::testing
