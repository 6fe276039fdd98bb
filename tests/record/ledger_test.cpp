#include "daemon/record/ledger.hpp"

#include <gtest/gtest.h>

#include <string>

#include "daemon/record/chain_file.hpp"
#include "tests/record/scratch.hpp"

namespace dwell::record {
namespace {

RunHeader next_header(const Ledger& ledger) {
  RunHeader header;
  header.run = ledger.next_run();
  header.id = std::string(31, '0') + std::to_string(header.run);
  header.previous_head = ledger.newest_head();
  header.start_utc = "2026-11-23T03:12:17.250000Z";
  return header;
}

std::string some_head(unsigned char seed) {
  Digest head{};
  head[0] = seed;
  return hex(head);
}

TEST(Ledger, RunsAreNumberedAndChainedAcrossRestarts) {
  const Scratch scratch;
  const SigningKey key = *SigningKey::make("rig-7");
  {
    Result<Ledger> ledger = Ledger::open(scratch.path(), key);
    ASSERT_TRUE(ledger) << ledger.error();
    EXPECT_EQ(ledger->next_run(), 1);
    EXPECT_EQ(ledger->newest_head(), "");
    ASSERT_TRUE(ledger->run_begins(next_header(*ledger), "a.dwell"));
    EXPECT_EQ(ledger->running(), 1);
    EXPECT_FALSE(ledger->run_begins(next_header(*ledger), "b.dwell")) << "one run at a time";
    ASSERT_TRUE(ledger->run_ends({1, some_head(1), 40, "closed"}));
    ASSERT_TRUE(ledger->run_begins(next_header(*ledger), "b.dwell"));
  }
  Ledger ledger = *Ledger::open(scratch.path(), key);
  EXPECT_EQ(ledger.running(), 2) << "it was cut off";
  ASSERT_TRUE(ledger.run_ends({2, "", 0, "cut off"}));
  EXPECT_EQ(ledger.newest_head(), some_head(1)) << "a run without entries has no head";
  RunHeader wrong = next_header(ledger);
  wrong.previous_head = some_head(9);
  EXPECT_FALSE(ledger.run_begins(wrong, "c.dwell"));
  ASSERT_TRUE(ledger.run_begins(next_header(ledger), "c.dwell"));
  EXPECT_EQ(ledger.running(), 3);
}

TEST(Ledger, RetentionTellsWhatItDeletedOnce) {
  const Scratch scratch;
  Ledger ledger = *Ledger::open(scratch.path(), *SigningKey::make("rig-7"));
  ASSERT_TRUE(ledger.run_begins(next_header(ledger), "a.dwell"));
  EXPECT_FALSE(ledger.run_deleted(1, "older than 90 days")) << "it is being recorded";
  ASSERT_TRUE(ledger.run_ends({1, some_head(1), 40, "closed"}));
  EXPECT_FALSE(ledger.run_deleted(2, "older than 90 days")) << "no such run";
  ASSERT_TRUE(ledger.run_deleted(1, "older than 90 days"));
  EXPECT_FALSE(ledger.run_deleted(1, "older than 90 days"));
}

TEST(Ledger, AChangeOfKeysIsSignedByTheOldKeyAndTheNewOneGoesOn) {
  const Scratch scratch;
  const SigningKey old_key = *SigningKey::make("rig-7"), next = *SigningKey::make("rig-7-2027");
  {
    Ledger ledger = *Ledger::open(scratch.path(), old_key);
    EXPECT_FALSE(Ledger::open(scratch.path(), next)) << "not yet";
    ASSERT_TRUE(ledger.key_changes(next.public_key()));
    EXPECT_FALSE(ledger.run_begins(next_header(ledger), "a.dwell"));
  }
  EXPECT_FALSE(Ledger::open(scratch.path(), old_key));
  for (int i = 0; i < 2; ++i) {
    Result<Ledger> ledger = Ledger::open(scratch.path(), next);
    ASSERT_TRUE(ledger) << ledger.error();
    ASSERT_TRUE(ledger->run_begins(next_header(*ledger), "a.dwell"));
    ASSERT_TRUE(ledger->run_ends({i + 1, some_head(1), 3, "closed"}));
  }
}

TEST(Ledger, ALedgerThatWasAlteredIsNotGoneOnWith) {
  const Scratch scratch;
  const SigningKey key = *SigningKey::make("rig-7");
  {
    Ledger ledger = *Ledger::open(scratch.path(), key);
    ASSERT_TRUE(ledger.run_begins(next_header(ledger), "a.dwell"));
  }
  const std::string path = scratch.path("ledger.dwell-ledger");
  std::string bytes = Scratch::read(path);
  const std::size_t at = bytes.find("a.dwell");
  ASSERT_NE(at, std::string::npos);
  bytes[at] = 'b';
  scratch.write("ledger.dwell-ledger", bytes);
  EXPECT_FALSE(Ledger::open(scratch.path(), key));
}

}  // namespace
}  // namespace dwell::record
