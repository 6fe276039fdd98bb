// What is asked of a node and set in it, against dictionaries that answer as CiA 301 allows, and refuse as it demands.
#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "drivers/canopen/configurator.hpp"
#include "drivers/canopen/words.hpp"

namespace dwell::canopen {
namespace {

constexpr std::uint8_t kNodeSetUp = 5;
constexpr std::uint32_t kNotValid = 1U << 31U, kNoObject = 0x06020000, kWrongValue = 0x06090030;

// Node 5 of CiA 404: 9130h:01 as INTEGER32 in TPDO 1.
class Dictionary : public ::testing::Test {
 protected:
  struct Entry {
    std::uint32_t value = 0;
    std::size_t bytes = 4;
  };
  using Key = std::pair<unsigned, unsigned>;

  static Wish wish() {
    Wish wish;
    wish.node = kNodeSetUp;
    wish.wanted.push_back({{0x9130, 1}, {Kind::signed_integer, 32}, 0});
    return wish;
  }
  // Asks and sets until it is over; what was written to 1800h is in `written_`.
  void run() {
    configurator_.begin();
    for (int i = 0; configurator_.request() != nullptr; ++i) {
      ASSERT_LT(i, 100);
      const Request request = *configurator_.request();
      const Key key{request.object.index, request.object.sub_index};
      if (entries_.count(key) == 0)
        configurator_.answer({kNoObject, {}});
      else if (request.value)
        write(key, *request.value);
      else
        configurator_.answer({std::nullopt, bytes_of(entries_[key])});
    }
  }

  std::map<Key, Entry> entries_{{{0x1000, 0}, {0x00020194, 4}}, {{0x1005, 0}, {0x80, 4}}, {{0x1017, 0}, {0, 2}},
                                {{0x1800, 1}, {0x185, 4}},      {{0x1800, 2}, {1, 1}},    {{0x1A00, 0}, {1, 1}},
                                {{0x1A00, 1}, {0x91300120, 4}}};
  bool sized_ = true;
  // The abort code for a value of 1800h:01; 0: taken.
  std::function<std::uint32_t(std::uint32_t before, std::uint32_t value)> refusal_ = [](auto, auto) { return 0U; };
  std::vector<std::string> written_;
  Configurator configurator_{wish()};

 private:
  std::span<const std::uint8_t> bytes_of(const Entry& entry) {
    room_ = {0xA5, 0xA5, 0xA5, 0xA5};
    put_le(std::span(room_).first(entry.bytes), entry.value);
    return std::span(room_).first(sized_ ? entry.bytes : room_.size());
  }
  void write(const Key& key, std::uint32_t value) {
    const bool identifier = key == Key{0x1800, 1};
    const std::uint32_t code = identifier ? refusal_(entries_[key].value, value) : 0;
    if (key.first == 0x1800)
      written_.push_back(std::to_string(key.second) + ": " + hex(value) + (code == 0 ? "" : " refused"));
    if (code != 0) return configurator_.answer({code, {}});
    entries_[key].value = value;
    configurator_.answer({std::nullopt, {}});
  }

  std::array<std::uint8_t, 4> room_{};
};

TEST_F(Dictionary, IsReadByTheWidthOfItsObjectsWhereAnswersDoNotTellTheirLength) {
  sized_ = false;
  entries_[{0x1017, 0}].value = 100;
  entries_[{0x1800, 2}].value = 254;
  run();
  ASSERT_EQ(configurator_.failure(), "");
  ASSERT_EQ(configurator_.pdos().size(), 1U);
  EXPECT_EQ(configurator_.pdos()[0].id, 0x185U);
  EXPECT_EQ(configurator_.heartbeat_ms(), 100);
}

using Lines = std::vector<std::string>;

TEST_F(Dictionary, HasItsIdentifierChangedOnlyWhileItIsDisabled) {
  entries_[{0x1800, 1}].value = 0x40000666;
  entries_[{0x1800, 2}].value = 254;
  refusal_ = [](std::uint32_t before, std::uint32_t value) {
    const bool changed = ((before ^ value) & ~(3U << 30U)) != 0;
    return (before & kNotValid) == 0 && changed ? kWrongValue : 0U;
  };
  run();
  EXPECT_EQ(configurator_.failure(), "");
  EXPECT_EQ(written_, (Lines{"1: 0xC0000666", "2: 0x1", "1: 0x40000185"}));
}

TEST_F(Dictionary, IsGivenItsIdentifierBeforeItIsEnabledWhereBothAtOnceIsRefused) {
  entries_[{0x1800, 1}].value = 0x666;
  refusal_ = [](std::uint32_t before, std::uint32_t value) {
    const bool changed = ((before ^ value) & ~kNotValid) != 0;
    return changed && ((before & kNotValid) == 0 || (value & kNotValid) == 0) ? kWrongValue : 0U;
  };
  run();
  EXPECT_EQ(configurator_.failure(), "");
  EXPECT_EQ(written_, (Lines{"1: 0x80000666", "2: 0x1", "1: 0x185 refused", "1: 0x80000185", "1: 0x185"}));
}

TEST_F(Dictionary, IsGivenUpWhereItsIdentifierIsRefusedAgain) {
  entries_[{0x1800, 1}].value = 0x80000666;
  refusal_ = [](std::uint32_t, std::uint32_t value) { return (value & kNotValid) == 0 ? kWrongValue : 0U; };
  run();
  EXPECT_NE(configurator_.failure().find("cannot set the identifier of TPDO 1, 1800h:01: "), std::string::npos)
      << configurator_.failure();
  EXPECT_EQ(written_, (Lines{"2: 0x1", "1: 0x185 refused", "1: 0x80000185", "1: 0x185 refused"}));
}

TEST_F(Dictionary, KeepsAnIdentifierThatCannotBeWritten) {
  entries_[{0x1800, 2}].value = 254;
  refusal_ = [](auto, auto) { return kWrongValue; };
  run();
  EXPECT_EQ(configurator_.failure(), "");
  EXPECT_EQ(written_, (Lines{"1: 0x80000185 refused", "2: 0x1"}));
}

}  // namespace
}  // namespace dwell::canopen
