#include "daemon/record/run_audits.hpp"

#include <gtest/gtest.h>

#include <climits>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include "daemon/record/ledger_check.hpp"
#include "tests/record/audited.hpp"
#include "tests/record/scratch.hpp"

namespace dwell::record {
namespace {

ListedRun listed(std::int64_t run, const std::string& file, const char* state = "closed") {
  ListedRun one;
  one.run = run;
  one.file = file;
  one.state = state;
  return one;
}

// A directory with three runs: a and b are closed, c was cut off. The tests run in virtual time.
struct RunAuditsTest : testing::Test {
  // Calls turn() at one instant of virtual time until `known` is true.
  void turn_until(double t_s, const std::function<bool()>& known) {
    do {
      audits->turn(static_cast<std::int64_t>(t_s * 1e9), runs, service_key);
      for (const std::string& line : audits->take_tampered()) tampered.push_back(line);
      std::this_thread::yield();
    } while (!known());
  }
  [[nodiscard]] const RunVerdict* of(const char* file) {
    verdicts = audits->all();
    const auto found = verdicts->find(file);
    return found == verdicts->end() ? nullptr : &found->second;
  }

  Scratch scratch;
  PublicKey service_key = sample_key().public_key();
  Ledger ledger = recorded(scratch, 3, true);
  std::shared_ptr<const ListedRuns> runs = std::make_shared<ListedRuns>(
      ListedRuns{listed(1, "a.dwell"), listed(2, "b.dwell"), listed(3, "c.dwell", "cut off")});
  std::optional<RunAudits> audits{std::in_place, scratch.path()};
  std::shared_ptr<const RunVerdicts> verdicts;
  std::vector<std::string> tampered;
};

TEST_F(RunAuditsTest, TellsOfEachRunWhatTheAuditSays) {
  forge(scratch.path("a.dwell"), "UPDATE entry SET t_ns = t_ns + 1 WHERE seq = 3");
  turn_until(0.0, [&] { return of("a.dwell") != nullptr; });
  ASSERT_NE(of("c.dwell"), nullptr) << "the newest first";
  EXPECT_EQ(of("c.dwell")->state, AuditState::open);
  EXPECT_TRUE(of("c.dwell")->until_s.has_value());
  EXPECT_EQ(of("b.dwell")->state, AuditState::intact);
  EXPECT_TRUE(of("b.dwell")->trusted) << "by the service's own key";
  EXPECT_EQ(of("a.dwell")->state, AuditState::tampered);
  EXPECT_EQ(of("a.dwell")->where, audited(scratch.path("a.dwell"), with_ledger(scratch)).where);
  turn_until(0.0, [&] { return !tampered.empty(); });
  EXPECT_EQ(tampered.front(), "a.dwell is tampered with: " + of("a.dwell")->where);
}

TEST_F(RunAuditsTest, ADirectoryThatWasWrittenAnewWithAnotherKeyIsTampered) {
  service_key = sample_other().public_key();
  turn_until(0.0, [&] { return of("b.dwell") != nullptr; });
  EXPECT_EQ(of("b.dwell")->state, AuditState::tampered);
  EXPECT_FALSE(of("b.dwell")->trusted);
  EXPECT_NE(of("b.dwell")->where.find("not by the key asked for"), std::string::npos) << of("b.dwell")->where;
}

TEST_F(RunAuditsTest, AKeyThatHasSignedNothingYetMakesNoEarlierRunTampered) {
  ASSERT_TRUE(ledger.key_changes(sample_other().public_key()));
  service_key = sample_other().public_key();
  turn_until(0.0, [&] { return of("b.dwell") != nullptr; });
  EXPECT_EQ(of("b.dwell")->state, AuditState::intact) << of("b.dwell")->where;
  EXPECT_FALSE(of("b.dwell")->trusted);
}

TEST_F(RunAuditsTest, OnceANewKeyHasSignedTheRunsBeforeItAreTrusted) {
  ASSERT_TRUE(ledger.key_changes(sample_other().public_key()));
  service_key = sample_other().public_key();
  turn_until(0.0, [&] { return of("a.dwell") != nullptr; });
  EXPECT_FALSE(of("b.dwell")->trusted);
  { const Ledger closed = std::move(ledger); }
  {
    Result<Ledger> opened = Ledger::open(scratch.path(), sample_other());
    ASSERT_TRUE(opened) << opened.error();
    Ledger& later = *opened;
    RunHeader header = sample_header(4, sample_other());
    header.previous_head = later.newest_head();
    ASSERT_TRUE(later.run_begins(header, "d.dwell"));
    write_sample(scratch.path("d.dwell"), {.seed = 4, .header = header}, sample_other());
  }
  auto listed_now = *runs;
  listed_now.push_back(listed(4, "d.dwell", "recording"));
  runs = std::make_shared<ListedRuns>(listed_now);
  turn_until(1.0, [&] { return of("a.dwell")->trusted; });
  EXPECT_TRUE(of("b.dwell")->trusted);
}

TEST_F(RunAuditsTest, ReadsAFileAgainOnlyWhereItHasChanged) {
  turn_until(0.0, [&] { return of("a.dwell") != nullptr; });
  const std::string first = of("b.dwell")->utc;
  forge(scratch.path("a.dwell"), "UPDATE entry SET t_ns = t_ns + 1 WHERE seq = 3");
  turn_until(601.0, [&] { return of("a.dwell")->state == AuditState::tampered; });
  EXPECT_EQ(of("b.dwell")->utc, first) << "that one has not changed";
}

TEST_F(RunAuditsTest, TriesAgainWhatItCouldNotAudit) {
  const std::string ledger_path = scratch.path("ledger.dwell-ledger"), away = scratch.path("away");
  std::filesystem::rename(ledger_path, away);
  std::filesystem::create_directory(ledger_path);
  turn_until(0.0, [&] { return of("a.dwell") != nullptr; });
  EXPECT_NE(of("b.dwell")->why_none, "");
  std::filesystem::remove(ledger_path);
  std::filesystem::rename(away, ledger_path);
  turn_until(601.0, [&] { return of("b.dwell")->why_none.empty(); });
  EXPECT_EQ(of("b.dwell")->state, AuditState::intact);
}

TEST_F(RunAuditsTest, ForgetsWhatIsNoLongerListedAndLeavesOutWhatIsRecorded) {
  turn_until(0.0, [&] { return of("a.dwell") != nullptr; });
  std::filesystem::remove(scratch.path("a.dwell"));
  runs = std::make_shared<ListedRuns>(ListedRuns{listed(2, "b.dwell"), listed(4, "d.dwell", "recording")});
  turn_until(1.0, [&] { return of("a.dwell") == nullptr; });
  EXPECT_EQ(of("d.dwell"), nullptr);
  EXPECT_NE(of("b.dwell"), nullptr);
}

TEST_F(RunAuditsTest, ARunWhoseFileSomebodyRemovedHasNoVerdictAnyMore) {
  turn_until(0.0, [&] { return of("a.dwell") != nullptr; });
  std::filesystem::remove(scratch.path("b.dwell"));
  turn_until(61.0, [&] { return of("b.dwell")->removed; });
  EXPECT_EQ(of("b.dwell")->why_none, "its file was removed");
  EXPECT_EQ(of("a.dwell")->state, AuditState::intact);
}

TEST_F(RunAuditsTest, AuditsTheNewestOnly) {
  auto many = std::make_shared<ListedRuns>(ListedRuns{listed(1, "a.dwell"), listed(2, "b.dwell")});
  for (std::size_t i = 1; i < RunAudits::kAudited; ++i)
    many->push_back(listed(10 + static_cast<std::int64_t>(i), "gone.dwell"));
  runs = many;
  turn_until(0.0, [&] { return of("b.dwell") != nullptr; });
  for (int i = 0; i < 1000; ++i) turn_until(1.0, [] { return true; });
  EXPECT_EQ(of("a.dwell"), nullptr);
}

// The service ends while a large file is read.
TEST_F(RunAuditsTest, AnAuditIsGivenUpWhenItIsAsked) {
  AuditOptions options = with_ledger(scratch);
  int asked = 0;
  options.stop = [&] { return ++asked > 2; };
  const Result<Audit> audit = audit_run(scratch.path("a.dwell"), options);
  ASSERT_FALSE(audit);
  EXPECT_EQ(audit.error(), kAuditStopped);
  EXPECT_EQ(asked, 3) << "and not tried again";
}

// Wherever it is: in the ledger, between two entries, or while SQLite looks whether the database is sound.
TEST_F(RunAuditsTest, AnAuditIsGivenUpAtTheNextPageThatItWouldRead) {
  AuditOptions options = with_ledger(scratch);
  int asked = 0, most = INT_MAX;
  options.stop = [&] { return ++asked > most; };
  const auto look = [&](const auto& read) {
    asked = 0;
    return read();
  };
  const auto check = [&] { return check_ledger(options.ledger, options); };
  const auto audit_it = [&] { return audit_run(scratch.path("a.dwell"), options); };
  ASSERT_TRUE(look(check)->verifies());
  const int of_ledger = asked;
  EXPECT_GT(of_ledger, 0);
  ASSERT_EQ(look(audit_it)->state, AuditState::intact);
  const int of_both = asked;
  EXPECT_GT(of_both, of_ledger);
  for (most = 0; most < of_both; ++most) {
    const auto audit = look(audit_it);
    ASSERT_FALSE(audit) << most;
    EXPECT_EQ(audit.error(), kAuditStopped) << most;
    EXPECT_EQ(asked, most + 1) << "and not tried again";
    const auto checked = look(check);
    EXPECT_EQ(!checked, most < of_ledger) << most;
    EXPECT_EQ(checked ? "" : checked.error(), most < of_ledger ? kAuditStopped : "") << most;
  }
}

}  // namespace
}  // namespace dwell::record
