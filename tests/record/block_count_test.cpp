#include "daemon/record/block_count.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "daemon/record/block.hpp"

namespace dwell::record {
namespace {

TEST(BlockCount, CountsTheSamplesThatDecodingFinds) {
  std::mt19937 random(3);
  BlockCount count;
  for (const std::size_t size : {0u, 1u, 7u, 300u, 200'000u}) {
    std::vector<Record> records(size);
    for (Record& record : records) {
      record.kind = static_cast<Kind>(random() % 8);
      record.value = static_cast<double>(random());
    }
    const auto expected =
        std::count_if(records.begin(), records.end(), [](const Record& record) { return record.kind == Kind::sample; });
    const std::string block = encode_block(records);
    EXPECT_EQ(count.samples(block).value_or(999'999), static_cast<std::uint64_t>(expected));
  }
}

TEST(BlockCount, WhatIsNoBlockIsRefused) {
  BlockCount count;
  const std::string block = encode_block(std::vector<Record>(300));
  EXPECT_EQ(count.samples(block).value_or(0), 300u);
  for (std::size_t size = 0; size < 14; ++size) EXPECT_FALSE(count.samples(block.substr(0, size))) << size;
  for (const std::size_t at : {0u, 4u, 6u, 7u, 8u}) {
    std::string other = block;
    other[at] = static_cast<char>(other[at] ^ 0x40);
    EXPECT_FALSE(count.samples(other)) << at;
  }
  EXPECT_EQ(count.samples(block).value_or(0), 300u) << "a bad block leaves nothing behind";
}

}  // namespace
}  // namespace dwell::record
