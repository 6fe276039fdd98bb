#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "drivers/can/decoder.hpp"

namespace dwell::can {
namespace {

canfd_frame frame(canid_t id, std::initializer_list<int> data) {
  canfd_frame made{};
  made.can_id = id;
  for (const int byte : data) made.data[made.len++] = static_cast<std::uint8_t>(byte);
  return made;
}
Match standard(canid_t id) { return {id, false, false, -1}; }
Match group(canid_t id) { return {id, true, true, -1}; }

// By its definition: bit by bit, in the order in which DBC files count.
std::uint64_t bit_by_bit(const std::uint8_t* data, const Field& field) {
  std::uint64_t bits = 0;
  unsigned at = field.start;
  for (unsigned i = 0; i < field.length; ++i) {
    const std::uint64_t bit = data[at / 8] >> at % 8 & 1U;
    if (field.order == Order::intel) {
      bits |= bit << i;
      ++at;
    } else {
      bits = bits << 1U | bit;
      at = at % 8 == 0 ? at + 15 : at - 1;
    }
  }
  return bits;
}

RC_GTEST_PROP(CanField, IsWhatItsBitsAreOneByOne, ()) {
  std::array<std::uint8_t, kMostBytes> data{};
  for (auto& byte : data) byte = *rc::gen::arbitrary<std::uint8_t>();
  Field field;
  field.order = *rc::gen::element(Order::intel, Order::motorola);
  field.length = static_cast<std::uint8_t>(*rc::gen::inRange(1, 65));
  field.start = static_cast<std::uint16_t>(*rc::gen::inRange(0, 512));
  RC_PRE(bytes_of(field) <= kMostBytes);
  RC_ASSERT(bits_of(data.data(), field) == bit_by_bit(data.data(), field));
}

TEST(CanField, ReadsSignsAndFloats) {
  EXPECT_EQ(number_of(0xFFF, {0, 12, Order::intel, Form::signed_integer}), -1.0);
  EXPECT_EQ(number_of(0xFFF, {0, 12, Order::intel, Form::unsigned_integer}), 4095.0);
  EXPECT_EQ(number_of(0x7FF, {0, 12, Order::intel, Form::signed_integer}), 2047.0);
  EXPECT_EQ(number_of(1, {0, 1, Order::intel, Form::signed_integer}), -1.0);
  EXPECT_EQ(number_of(0x8000000000000000U, {0, 64, Order::intel, Form::signed_integer}), -0x1p63);
  EXPECT_EQ(number_of(0xC0200000, {0, 32, Order::intel, Form::float32}), -2.5);
  EXPECT_EQ(number_of(0xC004000000000000, {0, 64, Order::intel, Form::float64}), -2.5);
}

TEST(CanDecoder, ScalesWhatItFinds) {
  Decoder decoder({{standard(0x123), {8, 16, Order::intel, Form::signed_integer}, 0.5, 10.0, {}}});
  const auto found = decoder.decode(frame(0x123, {0, 0xFE, 0xFF, 0}));
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].verdict, Verdict::value);
  EXPECT_EQ(found[0].value, 9.0);
  EXPECT_TRUE(decoder.decode(frame(0x124, {0, 0, 0, 0})).empty());
  EXPECT_TRUE(decoder.decode(frame(0x123 | CAN_EFF_FLAG, {0, 0, 0, 0})).empty());
  EXPECT_TRUE(decoder.decode(frame(0x123 | CAN_RTR_FLAG, {})).empty());
}

TEST(CanDecoder, TakesNothingFromAFrameThatEndsBeforeTheSignal) {
  Decoder decoder({{standard(1), {8, 16}, 1, 0, {}}, {standard(1), {0, 8}, 1, 0, {}}});
  const auto found = decoder.decode(frame(1, {7, 0xFE}));
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].verdict, Verdict::short_frame);
  EXPECT_EQ(found[1].value, 7.0);
}

TEST(CanDecoder, NeverPassesOnWhatIsNotANumber) {
  Decoder decoder({{standard(1), {0, 32, Order::intel, Form::float32}, 1, 0, {}}});
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    canfd_frame nan = frame(1, {0, 0, 0, 0});
    std::memcpy(nan.data, &bad, sizeof bad);
    EXPECT_EQ(decoder.decode(nan)[0].verdict, Verdict::invalid);
  }
}

TEST(CanDecoder, FollowsItsMultiplexors) {
  const Condition outer{{0, 4}, {{1, 1}, {3, 5}}}, inner{{4, 4}, {{2, 2}}};
  Decoder decoder({{standard(1), {8, 8}, 1, 0, {inner, outer}}});
  EXPECT_EQ(decoder.decode(frame(1, {0x21, 9}))[0].value, 9.0);
  EXPECT_EQ(decoder.decode(frame(1, {0x24, 9}))[0].verdict, Verdict::value);
  EXPECT_EQ(decoder.decode(frame(1, {0x22, 9}))[0].verdict, Verdict::absent);
  EXPECT_EQ(decoder.decode(frame(1, {0x11, 9}))[0].verdict, Verdict::absent);
  EXPECT_EQ(decoder.decode(frame(1, {}))[0].verdict, Verdict::short_frame);
}

TEST(CanDecoder, FindsAParameterGroupWhateverItsSourceAndPriority) {
  Decoder decoder({{group(0x18FEF100), {0, 8}, 1, 0, {}}});
  EXPECT_EQ(decoder.decode(frame(0x18FEF1AA | CAN_EFF_FLAG, {5}))[0].value, 5.0);
  EXPECT_EQ(decoder.decode(frame(0x0CFEF100 | CAN_EFF_FLAG, {6}))[0].value, 6.0);
  EXPECT_TRUE(decoder.decode(frame(0x18FEF200 | CAN_EFF_FLAG, {5})).empty());
  EXPECT_TRUE(decoder.decode(frame(0x19FEF100 | CAN_EFF_FLAG, {5})).empty()) << "another data page";
}

TEST(CanDecoder, FindsAGroupThatIsSentToADestinationWhateverThat) {
  Decoder decoder({{group(0x18EF2100), {0, 8}, 1, 0, {}}});
  EXPECT_EQ(decoder.decode(frame(0x18EF99AA | CAN_EFF_FLAG, {5})).size(), 1U);
  EXPECT_TRUE(decoder.decode(frame(0x18EE99AA | CAN_EFF_FLAG, {5})).empty());
}

TEST(CanDecoder, KeepsToOneSourceIfAsked) {
  Decoder decoder({{{0x18FEF100, true, true, 0x21}, {0, 8}, 1, 0, {}}});
  EXPECT_EQ(decoder.decode(frame(0x18FEF121 | CAN_EFF_FLAG, {5})).size(), 1U);
  EXPECT_TRUE(decoder.decode(frame(0x18FEF122 | CAN_EFF_FLAG, {5})).empty());
}

TEST(CanDecoder, KnowsTheJ1939CodesForErrorAndNotAvailable) {
  Decoder decoder({{group(0x18FEF100), {0, 16}, 1, 0, {}}, {group(0x18FEF100), {16, 2}, 1, 0, {}}});
  EXPECT_EQ(decoder.decode(frame(0x18FEF100 | CAN_EFF_FLAG, {0xFF, 0xFF, 3}))[0].verdict, Verdict::invalid);
  EXPECT_EQ(decoder.decode(frame(0x18FEF100 | CAN_EFF_FLAG, {0x00, 0xFE, 3}))[0].verdict, Verdict::invalid);
  EXPECT_EQ(decoder.decode(frame(0x18FEF100 | CAN_EFF_FLAG, {0xFF, 0xFA, 3}))[0].verdict, Verdict::value);
  EXPECT_EQ(decoder.decode(frame(0x18FEF100 | CAN_EFF_FLAG, {0, 0, 3}))[1].value, 3.0);
}

TEST(CanDecoder, AsksTheKernelForEachIdentifierOnce) {
  const Decoder decoder({{standard(1), {0, 8}, 1, 0, {}},
                         {standard(2), {0, 8}, 1, 0, {}},
                         {standard(1), {8, 8}, 1, 0, {}},
                         {{1, true, false, -1}, {0, 8}, 1, 0, {}},
                         {group(0x18FEF100), {0, 8}, 1, 0, {}},
                         {group(0x0CFEF155), {8, 8}, 1, 0, {}}});
  EXPECT_EQ(decoder.filters().size(), 4U);
}

// The kernel's rule: (id & mask) == (filter & mask).
RC_GTEST_PROP(CanDecoder, DecodesJustWhatItsFiltersPass, ()) {
  const auto some_id = [] { return *rc::gen::element<canid_t>(0x18FEF100, 0x18FEF101, 0x0CEF0301, 0x123, 0x100); };
  std::vector<Wanted> wanted(1);
  wanted[0].match = {some_id(), *rc::gen::arbitrary<bool>(), false, -1};
  wanted[0].match.j1939 = wanted[0].match.extended && *rc::gen::arbitrary<bool>();
  wanted[0].field = {0, 8};
  Decoder decoder(wanted);
  canfd_frame sent = frame(some_id() ^ *rc::gen::element<canid_t>(0, 1, 0x55, 0x1000, 0x30000, 0x10000000), {1});
  if (*rc::gen::arbitrary<bool>()) sent.can_id |= CAN_EFF_FLAG;
  bool passes = false;
  for (const can_filter& filter : decoder.filters())
    passes = passes || (sent.can_id & filter.can_mask) == (filter.can_id & filter.can_mask);
  RC_ASSERT(passes == !decoder.decode(sent).empty());
}

}  // namespace
}  // namespace dwell::can
