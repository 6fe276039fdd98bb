#include "daemon/record/block.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <limits>
#include <random>

#include "tests/record/noisy_signals.hpp"

namespace dwell::record {
namespace {

using Records = std::vector<Record>;

bool same_records(const Records& a, const Records& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Record)) == 0);
}

// Records whose fields come, by a throw of dice for each list, from sources that streams have and that they do not.
class AnyRecords {
 public:
  explicit AnyRecords(std::uint64_t seed) : random_(seed) {}

  Records list(std::size_t n) {
    instants_ = random_() % 4, values_ = random_() % 7, channels_ = random_() % 3;
    Records records;
    for (std::size_t i = 0; i < n; ++i) {
      Record r;
      r.t_ns = t_ns_ = instant();
      r.stamped_ns = random_() % 3 == 0
                         ? word()
                         : static_cast<std::int64_t>(static_cast<std::uint64_t>(r.t_ns) + random_() % 1000);
      r.value = value();
      r.t_half_ns = random_() % 4 == 0 ? static_cast<std::uint32_t>(random_()) : 250U;
      r.channel = static_cast<std::uint16_t>(channels_ == 0 ? i % 8 : channels_ == 1 ? random_() % 5 : random_());
      r.kind = static_cast<Kind>(channels_ == 2 ? random_() % 256 : random_() % 8);
      r.flags = static_cast<std::uint8_t>(random_() % 3 == 0 ? random_() : 0);
      records.push_back(r);
    }
    return records;
  }

 private:
  std::int64_t word() { return std::bit_cast<std::int64_t>(random_() >> random_() % 64); }
  std::int64_t instant() {
    constexpr auto kLeast = std::numeric_limits<std::int64_t>::min(), kMost = std::numeric_limits<std::int64_t>::max();
    if (instants_ == 0) return random_() % 2 == 0 ? kLeast : kMost;
    if (instants_ == 1) return word();
    const auto step = static_cast<std::int64_t>(random_() % 1000);
    return t_ns_ > kMost - 2000 || t_ns_ < kLeast + 2000 ? 0 : t_ns_ + (instants_ == 2 ? step : 300 - step);
  }
  double value() {
    using Limits = std::numeric_limits<double>;
    static const std::vector<double> kSpecial = {0.0,
                                                 -0.0,
                                                 Limits::infinity(),
                                                 -Limits::infinity(),
                                                 Limits::quiet_NaN(),
                                                 -Limits::quiet_NaN(),
                                                 Limits::max(),
                                                 Limits::lowest(),
                                                 Limits::denorm_min(),
                                                 0x1p53,
                                                 -0x1p53,
                                                 0x1p53 + 2,
                                                 0x1p63,
                                                 -0x1p63,
                                                 std::numeric_limits<float>::max(),
                                                 std::numeric_limits<float>::denorm_min(),
                                                 std::bit_cast<double>(0x7FF0000000000001ULL),  // signalling NaNs
                                                 std::bit_cast<double>(0xFFF4000020000000ULL),
                                                 std::bit_cast<double>(0x7FF8000020000000ULL)};  // fits a float's NaN
    switch (values_) {
      case 0:
        return kSpecial[random_() % kSpecial.size()];
      case 1:
        return std::bit_cast<double>(word());
      case 2:
        return static_cast<double>(static_cast<std::int16_t>(random_()));
      case 3:
        return static_cast<double>(word());
      case 4:
        return static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(random_())));
      case 5:
        return random_() % 50 == 0 ? kSpecial[random_() % kSpecial.size()] : static_cast<double>(random_() % 100);
      default:
        return 1e-3 * static_cast<double>(random_() % 1000);
    }
  }

  std::mt19937_64 random_;
  std::uint64_t instants_ = 0, values_ = 0, channels_ = 0;
  std::int64_t t_ns_ = 0;
};

TEST(Block, EveryRecordComesBackBitForBitAndInItsPlace) {
  for (std::uint64_t seed = 1; seed <= 600; ++seed) {
    const std::size_t lengths[] = {0, 1, 2, 511, 512, 513, 1024, seed * 7 % 3000};
    const Records records = AnyRecords(seed).list(lengths[seed % std::size(lengths)]);
    Records back(3);
    const auto decoded = decode_block(encode_block(records), back);
    ASSERT_TRUE(decoded) << "seed " << seed << ": " << decoded.error();
    ASSERT_TRUE(same_records(records, back)) << "seed " << seed;
  }
}

TEST(Block, TheFullestBlockComesBackToo) {
  Records records(kMaxBlockRecords);
  for (std::size_t i = 0; i < records.size(); ++i) {  // each of a kind and channel of its own
    records[i].channel = static_cast<std::uint16_t>(i);
    records[i].kind = static_cast<Kind>(i >> 16U);
  }
  Records back;
  ASSERT_TRUE(decode_block(encode_block(records), back));
  EXPECT_TRUE(same_records(records, back));
  records.emplace_back();
  const auto more = decode_block(encode_block(records), back);
  ASSERT_FALSE(more);
  EXPECT_EQ(more.error(), "block of 1048577 records: at most 1048576 are allowed");
  EXPECT_TRUE(back.empty());
}

double bytes_a_sample(Instants instants) {
  const Records records = noisy_signals(instants);
  return static_cast<double>(encode_block(records).size()) / static_cast<double>(records.size());
}

TEST(Block, NoisySamplesTakeFewBytes) {
  EXPECT_LT(bytes_a_sample(Instants::shared), 1.5);
  EXPECT_LT(bytes_a_sample(Instants::recovered), 3.2);
  EXPECT_LT(bytes_a_sample(Instants::irregular), 5.5);
}

std::string low_first(std::uint64_t number, int bytes) {
  std::string text;
  for (int k = 0; k < bytes; ++k) text.push_back(static_cast<char>(number >> 8 * k));
  return text;
}

// A block of `n` records whose zstd frame says that it holds `said` bytes and holds `parts`, each one byte repeated.
std::string block_by_hand(std::uint32_t n, std::uint32_t said,
                          const std::vector<std::pair<char, std::uint32_t>>& parts) {
  std::string block = low_first(1, 4) + low_first(n, 4) + "\x28\xB5\x2F\xFD\xA0" + low_first(said, 4);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const bool last = i + 1 == parts.size();
    block += low_first(parts[i].second << 3U | 2U | (last ? 1U : 0U), 3) + parts[i].first;
  }
  return block;
}

TEST(Block, ReadsAsThePageSays) {
  // Two records of kind 0, channel 1, flags 2, form 0. Planes: kind, flags, form, channel, half, instant, delay, value.
  const std::string block = block_by_hand(
      2, 66,
      {{0, 2}, {2, 2}, {0, 2}, {1, 2}, {0, 2}, {7, 2}, {0, 6}, {4, 2}, {0, 14}, {1, 2}, {0, 14}, {6, 2}, {0, 14}});
  Records records;
  const auto decoded = decode_block(block, records);
  ASSERT_TRUE(decoded) << decoded.error();
  ASSERT_EQ(records.size(), 2U);
  for (const Record& r : records) {
    EXPECT_EQ(r.kind, Kind::sample);
    EXPECT_EQ(r.channel, 1);
    EXPECT_EQ(r.flags, 2);
  }
  EXPECT_EQ(records[0].t_half_ns, 7U);
  EXPECT_EQ(records[1].t_half_ns, 14U);
  EXPECT_EQ(records[0].t_ns, 2);  // gaps 2 and 4
  EXPECT_EQ(records[1].t_ns, 6);
  EXPECT_EQ(records[0].stamped_ns, 1);  // delays -1 and -2
  EXPECT_EQ(records[1].stamped_ns, 4);
  EXPECT_EQ(records[0].value, 3.0);  // then 2 * 3 - 0 + 3
  EXPECT_EQ(records[1].value, 9.0);
}

std::string block_error(std::string_view block) {
  Records records(1);
  const auto decoded = decode_block(block, records);
  EXPECT_TRUE(decoded || records.empty());
  return decoded ? "" : decoded.error();
}

TEST(Block, AWrongBlockIsOneClearError) {
  EXPECT_EQ(block_error(""), "block of 0 bytes: a block has at least 8");
  EXPECT_EQ(block_error(low_first(2, 4) + low_first(0, 4)), "block of version 2: only version 1 is known");
  EXPECT_EQ(block_error(block_by_hand(0xFFFFFFFF, 66, {{0, 66}})),
            "block of 4294967295 records: at most 1048576 are allowed");
  EXPECT_EQ(block_error(block_by_hand(2, 65, {{0, 65}})),
            "block of 2 records: its zstd frame does not say that it holds 66 bytes");
  EXPECT_EQ(block_error(block_by_hand(2, 66, {{0, 66}}) + "x"),
            "block of 2 records: its zstd frame does not end with the block");
  EXPECT_EQ(block_error(block_by_hand(2, 66, {{0, 4}, {3, 2}, {0, 60}})),
            "block of 2 records: record 1 has a value of form 3, forms end at 2");
}

TEST(Block, AFrameThatHoldsMoreOrLessThanItSaysIsAnError) {
  EXPECT_NE(block_error(block_by_hand(2, 66, {{0, 66}, {0, 1}})), "");
  EXPECT_NE(block_error(block_by_hand(2, 66, {{0, 65}})), "");
  const std::vector<std::pair<char, std::uint32_t>> bomb(1000, {0, 128U << 10U});  // 131 MB in 4 kB
  EXPECT_NE(block_error(block_by_hand(2, 66, bomb)), "");
  EXPECT_NE(block_error(block_by_hand(kMaxBlockRecords, 33 * kMaxBlockRecords, bomb)), "");
}

TEST(Block, ACutBlockIsAnErrorWhereverItIsCut) {
  const std::string block = encode_block(AnyRecords(3).list(300));
  for (std::size_t size = 0; size < block.size(); ++size) ASSERT_NE(block_error(block.substr(0, size)), "") << size;
}

TEST(Block, AFlippedBitOrRandomBytesNeverCrashTheReader) {
  const std::string block = encode_block(AnyRecords(4).list(40));
  for (std::size_t bit = 0; bit < 8 * block.size(); ++bit) {
    std::string other = block;
    other[bit / 8] = static_cast<char>(other[bit / 8] ^ 1 << bit % 8);
    block_error(other);
  }
  std::mt19937_64 random(5);
  for (int k = 0; k < 2000; ++k) {
    std::string other = block.substr(0, random() % 20);
    for (std::size_t n = random() % 200; n > 0; --n) other.push_back(static_cast<char>(random()));
    block_error(other);
  }
}

}  // namespace
}  // namespace dwell::record
