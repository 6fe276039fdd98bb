// The SDO client against answers that are right, wrong, late or malicious; in virtual time.
#include <gtest/gtest.h>

#include <string>

#include "drivers/canopen/sdo_client.hpp"
#include "drivers/canopen/words.hpp"

namespace dwell::canopen {
namespace {

constexpr std::uint8_t kNode = 5;
constexpr Object kObject{0x1018, 1};

can_frame answer(std::initializer_list<std::uint8_t> bytes) { return make_frame(kSdoAnswer + kNode, bytes); }
// To an upload of 1018h:01, four bytes.
can_frame value(std::uint8_t first) { return answer({0x43, 0x18, 0x10, 1, first, 0, 0, 0}); }

class Sdo : public ::testing::Test {
 protected:
  std::string sent() {
    const auto frame = client_.to_send();
    if (!frame) return "";
    std::string text = hex(frame->can_id) + " ";
    for (unsigned i = 0; i < frame->can_dlc; ++i) {
      char digits[3];
      std::snprintf(digits, sizeof digits, "%02X", frame->data[i]);
      text += digits;
    }
    return text;
  }
  void wait(std::int64_t ns) { client_.tick(now_ns_ += ns); }

  std::int64_t now_ns_ = 1'000'000'000;
  SdoClient client_{kNode};
};

TEST_F(Sdo, ReadsUpToFourBytesAtOnce) {
  client_.upload(kObject, now_ns_);
  EXPECT_EQ(sent(), "0x605 4018100100000000");
  EXPECT_EQ(sent(), "");
  client_.take(answer({0x4B, 0x18, 0x10, 1, 0x34, 0x12, 0xFF, 0xFF}), now_ns_);
  ASSERT_EQ(client_.state(), SdoClient::State::done);
  ASSERT_EQ(client_.data().size(), 2U);
  EXPECT_EQ(get_le(client_.data()), 0x1234U);
}

TEST_F(Sdo, TellsWhetherTheNodeSaidHowLongAValueIs) {
  client_.upload(kObject, now_ns_);
  client_.take(answer({0x42, 0x18, 0x10, 1, 0x34, 0x12, 0xA5, 0xA5}), now_ns_);
  ASSERT_EQ(client_.state(), SdoClient::State::done);
  EXPECT_FALSE(client_.sized());
  EXPECT_EQ(client_.data().size(), 4U);
  client_.upload(kObject, now_ns_);
  client_.take(answer({0x4B, 0x18, 0x10, 1, 0x34, 0x12, 0xFF, 0xFF}), now_ns_);
  EXPECT_TRUE(client_.sized());
}

TEST_F(Sdo, ReadsLongerValuesInSegments) {
  client_.upload({0x1008, 0}, now_ns_);
  static_cast<void>(sent());
  client_.take(answer({0x41, 0x08, 0x10, 0, 10, 0, 0, 0}), now_ns_);
  EXPECT_EQ(sent(), "0x605 6000000000000000");
  client_.take(answer({0x00, 'a', 'b', 'c', 'd', 'e', 'f', 'g'}), now_ns_);
  EXPECT_EQ(sent(), "0x605 7000000000000000");
  client_.take(answer({0x19, 'h', 'i', 'j', 0, 0, 0, 0}), now_ns_);
  ASSERT_EQ(client_.state(), SdoClient::State::done);
  EXPECT_EQ(std::string(client_.data().begin(), client_.data().end()), "abcdefghij");
}

TEST_F(Sdo, WritesUpToFourBytesAtOnce) {
  client_.download({0x1800, 2}, 1, 1, now_ns_);
  EXPECT_EQ(sent(), "0x605 2F00180201000000");
  client_.take(answer({0x60, 0x00, 0x18, 2, 0, 0, 0, 0}), now_ns_);
  EXPECT_EQ(client_.state(), SdoClient::State::done);
  client_.download({0x1800, 1}, 0xC0000185, 4, now_ns_);
  EXPECT_EQ(sent(), "0x605 23001801850100C0");
}

TEST_F(Sdo, TellsWhatTheNodeAbortsWith) {
  client_.upload(kObject, now_ns_);
  client_.take(answer({0x80, 0x18, 0x10, 1, 0x11, 0x00, 0x09, 0x06}), now_ns_);
  ASSERT_EQ(client_.state(), SdoClient::State::aborted);
  EXPECT_EQ(abort_text(client_.abort_code()), "sub-index does not exist (0x06090011)");
  EXPECT_EQ(abort_text(0x12345678), "unknown abort code 0x12345678");
}

TEST_F(Sdo, AbortsAndAsksAgainAfterAPauseWhenNoAnswerComes) {
  client_.upload(kObject, now_ns_);
  static_cast<void>(sent());
  for (int i = 1; i < SdoClient::kAttempts; ++i) {
    wait(SdoClient::kTimeout_ns);
    EXPECT_EQ(sent(), "0x605 8018100100000405");
    wait(SdoClient::kPause_ns - 1);
    EXPECT_EQ(sent(), "");
    wait(1);
    EXPECT_EQ(sent(), "0x605 4018100100000000");
  }
  wait(SdoClient::kTimeout_ns);
  EXPECT_EQ(client_.state(), SdoClient::State::no_answer);
}

TEST_F(Sdo, NeverTakesALateAnswerForTheCurrentOne) {
  client_.upload(kObject, now_ns_);
  wait(SdoClient::kTimeout_ns);
  client_.take(value(1), now_ns_);  // in the pause
  EXPECT_EQ(client_.state(), SdoClient::State::busy);
  EXPECT_EQ(client_.take_late(), 1U);
  client_.upload({0x1018, 2}, now_ns_);
  client_.take(value(1), now_ns_);  // to the object before
  EXPECT_EQ(client_.state(), SdoClient::State::busy);
  client_.take(answer({0x60, 0x18, 0x10, 2, 0, 0, 0, 0}), now_ns_);  // to a download
  client_.take(answer({0x01, 1, 2, 3, 4, 5, 6, 7}), now_ns_);        // a segment
  client_.take(answer({0x80, 0x18, 0x10, 1, 0, 0, 4, 5}), now_ns_);  // an abort of the one before
  EXPECT_EQ(client_.state(), SdoClient::State::busy);
  EXPECT_EQ(client_.take_late(), 4U);
  client_.take(answer({0x43, 0x18, 0x10, 2, 9, 0, 0, 0}), now_ns_);
  ASSERT_EQ(client_.state(), SdoClient::State::done);
  EXPECT_EQ(client_.data()[0], 9);
}

TEST_F(Sdo, TakesNothingWhenNothingWasAsked) {
  client_.take(value(1), now_ns_);
  EXPECT_EQ(client_.state(), SdoClient::State::idle);
  EXPECT_EQ(client_.take_late(), 1U);
}

TEST_F(Sdo, AbortsASegmentOutOfTurnAndAsksAgain) {
  client_.upload({0x1008, 0}, now_ns_);
  static_cast<void>(sent());
  client_.take(answer({0x40, 0x08, 0x10, 0, 0, 0, 0, 0}), now_ns_);
  static_cast<void>(sent());
  client_.take(answer({0x10, 'x', 0, 0, 0, 0, 0, 0}), now_ns_);  // the toggle bit should be 0
  EXPECT_EQ(sent(), "0x605 8008100000000305");
  wait(SdoClient::kPause_ns);
  EXPECT_EQ(sent(), "0x605 4008100000000000");
}

TEST_F(Sdo, RefusesWhatIsTooLongOrWithoutEnd) {
  client_.upload({0x1008, 0}, now_ns_);
  static_cast<void>(sent());
  client_.take(answer({0x41, 0x08, 0x10, 0, 0, 0, 0, 0x80}), now_ns_);
  EXPECT_EQ(sent(), "0x605 8008100005000405");
  EXPECT_EQ(client_.state(), SdoClient::State::aborted);

  client_.upload({0x1008, 0}, now_ns_);
  client_.take(answer({0x40, 0x08, 0x10, 0, 0, 0, 0, 0}), now_ns_);
  client_.take(answer({0x0E, 0, 0, 0, 0, 0, 0, 0}), now_ns_);  // no bytes, and more to come
  EXPECT_EQ(client_.state(), SdoClient::State::aborted);

  client_.upload({0x1008, 0}, now_ns_);
  client_.take(answer({0x40, 0x08, 0x10, 0, 0, 0, 0, 0}), now_ns_);
  std::uint8_t toggle = 0;
  for (int i = 0; client_.state() == SdoClient::State::busy; ++i, toggle ^= 0x10U) {
    ASSERT_LT(i, 20);
    client_.take(answer({toggle, 1, 2, 3, 4, 5, 6, 7}), now_ns_);
  }
  EXPECT_EQ(client_.state(), SdoClient::State::aborted);
}

TEST_F(Sdo, RefusesALengthThatIsNotTheOneAnnounced) {
  client_.upload({0x1008, 0}, now_ns_);
  client_.take(answer({0x41, 0x08, 0x10, 0, 9, 0, 0, 0}), now_ns_);
  client_.take(answer({0x01, 1, 2, 3, 4, 5, 6, 7}), now_ns_);
  EXPECT_EQ(client_.state(), SdoClient::State::aborted);
}

TEST(CanopenWords, SayWhatEmergenciesMean) {
  EXPECT_EQ(emergency_text(0x4210), "0x4210 (device temperature)");
  EXPECT_EQ(emergency_text(0x4567), "0x4567 (temperature)");
  EXPECT_EQ(emergency_text(0x8130), "0x8130 (life guard or heartbeat error)");
  EXPECT_EQ(emergency_text(0x0000), "0x0000 (error reset or no error)");
  EXPECT_EQ(emergency_text(0xA000), "0xA000");
  EXPECT_EQ(error_register_text(0x09), "0x09 (generic, temperature)");
  EXPECT_EQ(error_register_text(0), "0x00 (none)");
}

}  // namespace
}  // namespace dwell::canopen
