// A loss of power right at the beginning of a run. The run's file is written first, so it may be there without the
// ledger's entry, and it may have its first name only.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "daemon/record/audit.hpp"
#include "daemon/record/file_name.hpp"
#include "daemon/record/ledger_check.hpp"
#include "daemon/record/run_folder.hpp"
#include "tests/record/child.hpp"
#include "tests/record/recorded_rig.hpp"
#include "tests/record/scratch.hpp"

namespace dwell::record {
namespace {

namespace fs = std::filesystem;

std::vector<NewEntry> one_event() {
  StoredEvent event;
  event.position = 1;
  event.utc = "2026-11-23T00:00:00Z";
  event.what = "state";
  event.text = "idle";
  return {{"event", 2, to_json(event)}};
}

std::vector<NewEntry> the_end() { return {{"end", 2, to_json(RunEnd{"operator", 0, 0, "2026-11-23T00:00:01Z"})}}; }

// The parts of a directory that a loss of power may take back, as they are now.
void copy_ledger(const std::string& from, const std::string& to) {
  fs::create_directories(to);
  for (const char* name : {"ledger.dwell-ledger", "ledger.dwell-ledger-wal"})
    fs::copy_file(from + "/" + name, to + "/" + name, fs::copy_options::overwrite_existing);
}

// Records `runs` runs, each right after the one before. The power is cut right after the last one's beginning. The
// ledger as it was when it had heard of the beginning of `known` runs, but of no later end, is in `ledger_before`.
std::string record_and_crash(const std::string& directory, const std::string& ledger_before, int runs, int known) {
  return in_child([&]() -> std::string {
    RunFolder folder(folder_options(directory));
    if (const auto ready = folder.ready(); !ready) return ready.error();
    RunHeader header = rig_header();
    header.start_utc = "2026-11-23T00:00:00Z";
    folder.settle();
    if (known == 0) copy_ledger(directory, ledger_before);
    for (int run = 1; run <= runs; ++run) {
      if (const auto begun = folder.begin(header, 1, one_event()); !begun) return begun.error();
      if (run == runs) break;
      if (const auto written = folder.write(one_event()); !written) return written.error();
      folder.settle();
      if (run == known) copy_ledger(directory, ledger_before);
      if (const auto ended = folder.end(the_end()); !ended) return ended.error();
    }
    folder.settle();
    vanish();
    return std::string();
  });
}

// Begins a run after the ledger has been moved away, so that it refuses the run's entry. Returns what went wrong.
std::string begin_without_ledger(RunFolder& folder, const std::string& ledger, const std::string& away) {
  if (const auto ready = folder.ready(); !ready) return ready.error();
  folder.settle();
  fs::rename(ledger, away);
  RunHeader header = rig_header();
  header.start_utc = "2026-11-23T00:00:00Z";
  const auto begun = folder.begin(header, 1, one_event());
  folder.settle();
  return begun ? std::string() : std::string(begun.error());
}

std::string run_file_of(const std::string& directory, std::int64_t run) {
  for (const auto& entry : fs::directory_iterator(directory))
    if (run_of_file_name(entry.path().filename().string()) == run) return entry.path().string();
  return {};
}

// The file as it is before its name is sure to survive.
void give_first_name(const std::string& directory, std::int64_t run) {
  const std::string file = run_file_of(directory, run), first = directory + "/next-" + std::to_string(run) + ".new";
  for (const char* part : {"", "-wal"})
    if (fs::exists(file + part)) fs::rename(file + part, first + part);
}

std::string ledger_says(const std::string& directory) {
  const auto audit = audit_ledger(directory + "/ledger.dwell-ledger", directory, {});
  if (!audit) return audit.error();
  std::string text = audit->unbroken ? "" : "broken: " + audit->where;
  for (const std::string& missing : audit->missing) text += " missing: " + missing;
  return text;
}

AuditState state_with_ledger(const std::string& file, const std::string& directory) {
  AuditOptions options;
  options.ledger = directory + "/ledger.dwell-ledger";
  const auto audit = audit_run(file, options);
  EXPECT_TRUE(audit) << audit.error();
  EXPECT_TRUE(!audit || audit->where.empty()) << audit->where;
  return audit ? audit->state : AuditState::tampered;
}

// Opens the folder as the next start does, and expects run `run` to be cut off, in its file, known to the ledger.
void expect_adopted(const std::string& directory, std::int64_t run) {
  {
    RunFolder folder(folder_options(directory));
    const auto opened = folder.open();
    ASSERT_TRUE(opened) << opened.error();
    const auto cut_off = folder.take_cut_off();
    ASSERT_TRUE(cut_off);
    EXPECT_EQ(cut_off->run, run);
    EXPECT_EQ(cut_off->file, fs::path(run_file_of(directory, run)).filename().string());
    EXPECT_EQ(cut_off->label, rig_header().label);
    EXPECT_EQ(cut_off->comment, rig_header().comment);
    EXPECT_EQ(ledger_says(directory), "");
    EXPECT_EQ(state_with_ledger(run_file_of(directory, run), directory), AuditState::open);
    EXPECT_FALSE(fs::exists(directory + "/next-" + std::to_string(run) + ".new"));
    RunHeader header = rig_header();
    header.start_utc = "2026-11-23T00:01:00Z";
    ASSERT_TRUE(folder.begin(header, 1, one_event()));
    EXPECT_EQ(header.run, run + 1);
    ASSERT_TRUE(folder.end(the_end()));
  }
  EXPECT_EQ(state_with_ledger(run_file_of(directory, run + 1), directory), AuditState::intact);
  EXPECT_EQ(ledger_says(directory), "");
}

TEST(ALossOfPowerAsARunBegins, LeavesTheRunWhereTheLedgerHasNotHeardOfIt) {
  const Scratch scratch, before;
  ASSERT_EQ(record_and_crash(scratch.path(), before.path(), 1, 0), "");
  copy_ledger(before.path(), scratch.path());
  give_first_name(scratch.path(), 1);
  expect_adopted(scratch.path(), 1);
}

TEST(ALossOfPowerAsARunBegins, LeavesTheRunUnderItsFirstName) {
  const Scratch scratch, before;
  ASSERT_EQ(record_and_crash(scratch.path(), before.path(), 1, 0), "");
  give_first_name(scratch.path(), 1);
  expect_adopted(scratch.path(), 1);
}

TEST(ALossOfPowerAsARunBegins, LeavesTheRunUnderBothNames) {
  const Scratch scratch, before;
  ASSERT_EQ(record_and_crash(scratch.path(), before.path(), 1, 0), "");
  for (const char* part : {"", "-wal"})
    fs::create_hard_link(run_file_of(scratch.path(), 1) + part, scratch.path("next-1.new") + part);
  expect_adopted(scratch.path(), 1);
}

TEST(ALossOfPowerAsARunBegins, LeavesTheLogAloneWithItsSecondName) {
  const Scratch scratch, before;
  ASSERT_EQ(record_and_crash(scratch.path(), before.path(), 1, 0), "");
  const std::string log = run_file_of(scratch.path(), 1) + "-wal";
  give_first_name(scratch.path(), 1);
  fs::create_hard_link(scratch.path("next-1.new-wal"), log);
  expect_adopted(scratch.path(), 1);
}

TEST(ALossOfPowerAsARunBegins, LeavesBothRunsWhereTheLedgerHasHeardOfNeitherTheEndOfOneNorOfTheOther) {
  const Scratch scratch, before;
  ASSERT_EQ(record_and_crash(scratch.path(), before.path(), 2, 1), "");
  copy_ledger(before.path(), scratch.path());
  give_first_name(scratch.path(), 2);
  expect_adopted(scratch.path(), 2);
  EXPECT_EQ(state_with_ledger(run_file_of(scratch.path(), 1), scratch.path()), AuditState::intact);
}

TEST(ALossOfPowerAsARunBegins, LeavesAllRunsWhereTheLedgerHasHeardOfNone) {
  const Scratch scratch, before;
  ASSERT_EQ(record_and_crash(scratch.path(), before.path(), 3, 0), "");
  copy_ledger(before.path(), scratch.path());
  for (const int run : {1, 2, 3}) give_first_name(scratch.path(), run);
  expect_adopted(scratch.path(), 3);
  for (const int run : {1, 2})
    EXPECT_EQ(state_with_ledger(run_file_of(scratch.path(), run), scratch.path()), AuditState::intact) << "run " << run;
}

// An earlier version entered it as one that never had a file.
TEST(ALossOfPowerAsARunBegins, DoesNotExcuseTheRunWhoseFileSomebodyRemoved) {
  const Scratch scratch, before;
  ASSERT_EQ(record_and_crash(scratch.path(), before.path(), 1, 0), "");
  const std::string file = run_file_of(scratch.path(), 1);
  for (const char* part : {"", "-wal"}) fs::remove(file + part);
  for (int start = 0; start < 2; ++start) {
    RunFolder folder(folder_options(scratch.path()));
    ASSERT_TRUE(folder.open()) << "start " << start;
  }
  EXPECT_NE(ledger_says(scratch.path()).find("missing: run 1 "), std::string::npos) << ledger_says(scratch.path());
}

// Audited by somebody else at that moment, it looked like a run that was slipped in.
TEST(ARunThatTheLedgerDoesNotKnowYet, IsNeitherTamperedNorIntact) {
  const Scratch scratch, before;
  ASSERT_EQ(record_and_crash(scratch.path(), before.path(), 1, 0), "");
  copy_ledger(before.path(), scratch.path());
  const std::string file = run_file_of(scratch.path(), 1), first = scratch.path("next-1.new");
  fs::create_hard_link(file, first);
  AuditOptions options;
  options.ledger = scratch.path("ledger.dwell-ledger");
  const auto audit = audit_run(file, options);
  ASSERT_FALSE(audit);
  EXPECT_EQ(audit.error(), file +
                               ": the ledger has no entry of run 1 yet: the service writes it as the run begins, after "
                               "a crash at its next start; audit it again then");
  fs::remove(first);
  EXPECT_EQ(audit_run(file, options)->where, "the ledger does not know run 1") << "it was slipped in";
}

TEST(ARunThatWasCutOff, HasTheLabelThatItWasGivenLast) {
  const Scratch scratch;
  ASSERT_EQ(in_child([&]() -> std::string {
              RunFolder folder(folder_options(scratch.path()));
              if (const auto ready = folder.ready(); !ready) return ready.error();
              RunHeader header = rig_header();
              header.start_utc = "2026-11-23T00:00:00Z";
              StoredEvent event;
              event.utc = "2026-11-23T00:00:00Z";
              event.what = "label";
              std::vector<NewEntry> labels;
              for (const char* label : {"oil film", "dry"}) {
                event.after = label;
                labels.push_back({"event", 2, to_json(event)});
              }
              if (const auto begun = folder.begin(header, 1, labels); !begun) return begun.error();
              folder.settle();
              vanish();
              return std::string();
            }),
            "");
  RunFolder folder(folder_options(scratch.path()));
  ASSERT_TRUE(folder.open());
  const auto cut_off = folder.take_cut_off();
  ASSERT_TRUE(cut_off);
  EXPECT_EQ(cut_off->label, "dry");
}

// The ledger was read before the service entered the run, and the file after that.
TEST(ARunThatTheLedgerDoesNotKnowYet, IsLookedUpAgainInTheLedgerAsItIsNow) {
  const Scratch scratch, before;
  ASSERT_EQ(record_and_crash(scratch.path(), before.path(), 1, 0), "");
  AuditOptions options;
  auto old = check_ledger(before.path("ledger.dwell-ledger"), options);
  ASSERT_TRUE(old) << old.error();
  options.ledger = scratch.path("ledger.dwell-ledger");
  options.checked = std::make_shared<const CheckedLedger>(std::move(*old));
  const auto audit = audit_run(run_file_of(scratch.path(), 1), options);
  ASSERT_TRUE(audit) << audit.error();
  EXPECT_EQ(audit->state, AuditState::open) << audit->where;
}

// A run ended while the ledger took nothing: its file is not closed, and has both names.
TEST(ALossOfPowerAsARunBegins, LeavesARunThatHasEndedAndThatTheLedgerHasRefused) {
  const Scratch scratch;
  const std::string ledger = scratch.path("ledger.dwell-ledger"), away = scratch.path("away");
  ASSERT_EQ(in_child([&]() -> std::string {
              RunFolder folder(folder_options(scratch.path()));
              if (const std::string begun = begin_without_ledger(folder, ledger, away); !begun.empty()) return begun;
              if (const auto ended = folder.end(the_end()); !ended) return ended.error();
              folder.settle();
              vanish();
              return std::string();
            }),
            "");
  ASSERT_TRUE(fs::exists(scratch.path("next-1.new-wal"))) << "not what this test is about";
  // The first start can write nothing into the ledger either, and must leave the run to the next one.
  fs::rename(away, ledger);
  const std::string own = Scratch::read(ledger);
  fs::remove(ledger);
  fs::create_directory(ledger);
  {
    RunFolder folder(folder_options(scratch.path()));
    EXPECT_FALSE(folder.open());
  }
  ASSERT_TRUE(fs::exists(scratch.path("next-1.new"))) << "nothing would find the run";
  fs::remove(ledger);
  scratch.write("ledger.dwell-ledger", own);
  {
    RunFolder folder(folder_options(scratch.path()));
    const auto opened = folder.open();
    ASSERT_TRUE(opened) << opened.error();
    EXPECT_FALSE(folder.take_cut_off()) << "it had ended";
  }
  EXPECT_EQ(ledger_says(scratch.path()), "");
  EXPECT_EQ(state_with_ledger(run_file_of(scratch.path(), 1), scratch.path()), AuditState::intact);
}

// SQLite closes their files then, under the names by which it opened them.
TEST(ALedgerThatRefusesTheBeginningOfARun, LeavesARunThatTheNextStartFindsIfTheServiceEndsMeanwhile) {
  const Scratch scratch;
  const std::string ledger = scratch.path("ledger.dwell-ledger"), away = scratch.path("away");
  {
    RunFolder folder(folder_options(scratch.path()));
    ASSERT_EQ(begin_without_ledger(folder, ledger, away), "");
    ASSERT_TRUE(folder.end(the_end()));
    folder.settle();
    const auto told = folder.take_failures();
    ASSERT_FALSE(told.empty());
    EXPECT_NE(told.back().find("the ledger has not taken its last entries: "), std::string::npos) << told.back();
  }
  fs::rename(away, ledger);
  RunFolder folder(folder_options(scratch.path()));
  const auto opened = folder.open();
  ASSERT_TRUE(opened) << opened.error();
  EXPECT_EQ(ledger_says(scratch.path()), "");
  EXPECT_EQ(state_with_ledger(run_file_of(scratch.path(), 1), scratch.path()), AuditState::intact);
}

TEST(ALossOfPowerAsARunBegins, LeavesAnEmptyFileBehindThatNoRunHasTaken) {
  const Scratch scratch, before;
  ASSERT_EQ(in_child([&]() -> std::string {
              RunFolder folder(folder_options(scratch.path()));
              if (const auto ready = folder.ready(); !ready) return ready.error();
              folder.settle();
              vanish();
              return std::string();
            }),
            "");
  ASSERT_TRUE(fs::exists(scratch.path("next-1.new")));
  RunFolder folder(folder_options(scratch.path()));
  ASSERT_TRUE(folder.open());
  EXPECT_FALSE(folder.take_cut_off());
  EXPECT_EQ(ledger_says(scratch.path()), "");
}

// Recording without an entry in the ledger would go unnoticed until an audit.
TEST(ALedgerThatRefusesTheBeginningOfARun, EndsTheRecordingAndGetsItsEntriesWhenItCanTakeThem) {
  const Scratch scratch;
  const std::string ledger = scratch.path("ledger.dwell-ledger"), away = scratch.path("away");
  {
    RunFolder folder(folder_options(scratch.path()));
    ASSERT_EQ(begin_without_ledger(folder, ledger, away), "");
    RunHeader header = rig_header();
    header.start_utc = "2026-11-23T00:00:01Z";
    const std::string why =
        ledger + ": the file was removed while it was written; put it back, or restart the service to begin a new one";
    EXPECT_EQ(folder.write(one_event()).error(), why);
    EXPECT_TRUE(folder.end(the_end())) << "the file is closed";
    folder.settle();
    EXPECT_EQ(folder.ready().error(), why);
    EXPECT_EQ(folder.begin(header, 1, one_event()).error(), why);
    fs::rename(away, ledger);
    [[maybe_unused]] const auto tries = folder.ready();
    folder.settle();
    EXPECT_TRUE(folder.ready());
    EXPECT_EQ(folder.take_ended().size(), 1U);
  }
  EXPECT_EQ(ledger_says(scratch.path()), "");
  EXPECT_EQ(state_with_ledger(run_file_of(scratch.path(), 1), scratch.path()), AuditState::intact);
  EXPECT_FALSE(fs::exists(scratch.path("next-1.new")));
}

// The full name of the run, at which something else stands.
std::string foreign_file(const Scratch& scratch) { return scratch.write("bench-1-20261123T000000Z.dwell", "foreign"); }

TEST(AFileAtTheFirstNameOfARun, ThatCannotBeReadIsLeftWhereItIsAndNothingIsRecordedThere) {
  const Scratch scratch;
  const std::string file = scratch.write("next-1.new", "half a run, perhaps");
  {
    RunFolder folder(folder_options(scratch.path()));
    const auto opened = folder.open();
    ASSERT_FALSE(opened);
    EXPECT_NE(opened.error().find(fs::path(file).filename().string()), std::string::npos) << opened.error();
    EXPECT_NE(opened.error().find("it may hold a run: move it elsewhere"), std::string::npos) << opened.error();
  }
  EXPECT_EQ(Scratch::read(file), "half a run, perhaps");
  fs::rename(file, scratch.path("elsewhere"));
  RunFolder folder(folder_options(scratch.path()));
  const auto opened = folder.open();
  EXPECT_TRUE(opened) << opened.error();
}

TEST(AFileAtTheFirstNameOfARun, ThatComesWhileTheServiceRunsIsNotDeleted) {
  const Scratch scratch;
  std::string file;
  {
    RunFolder folder(folder_options(scratch.path()));
    ASSERT_TRUE(folder.ready());
    folder.settle();
    fs::rename(scratch.path("next-1.new"), scratch.path("elsewhere"));
    fs::rename(scratch.path("next-1.new-wal"), scratch.path("elsewhere-wal"));
    RunHeader header = rig_header();
    header.start_utc = "2026-11-23T00:00:00Z";
    ASSERT_FALSE(folder.begin(header, 1, one_event())) << "its prepared file is gone";
    file = scratch.write("next-1.new", "foreign");
    ASSERT_FALSE(folder.begin(header, 1, one_event())) << "its first name is another file's";
  }
  EXPECT_EQ(Scratch::read(file), "foreign");
}

TEST(AFileAtTheNameOfARun, IsNotTheRunsAndStays) {
  const Scratch scratch;
  const std::string file = foreign_file(scratch);
  RunFolder folder(folder_options(scratch.path()));
  ASSERT_TRUE(folder.ready());
  RunHeader header = rig_header();
  header.start_utc = "2026-11-23T00:00:00Z";
  EXPECT_FALSE(folder.begin(header, 1, one_event()));
  EXPECT_EQ(Scratch::read(file), "foreign");
  header.start_utc = "2026-11-23T00:00:01Z";
  EXPECT_TRUE(folder.begin(header, 1, one_event())) << "a second later it has another name";
}

// A copy was put in the file's place: SQLite went on in a file that no name leads to, and nothing was left of the run.
TEST(AFileAtTheNameOfARun, ThatReplacesTheRunsOwnEndsTheRecording) {
  const Scratch scratch;
  RunFolder folder(folder_options(scratch.path()));
  ASSERT_TRUE(folder.ready());
  folder.settle();
  const auto replace = [](const std::string& path) {
    fs::copy_file(path, path + ".copy");
    fs::rename(path + ".copy", path);
  };
  replace(scratch.path("next-1.new"));
  RunHeader header = rig_header();
  header.start_utc = "2026-11-23T00:00:00Z";
  const std::string why = folder.begin(header, 1, one_event()).error();
  EXPECT_NE(why.find("next-1.new: was replaced while it was written"), std::string::npos) << why;
  ASSERT_TRUE(fs::exists(scratch.path("next-1.new"))) << "it belongs to somebody else";
  fs::remove(scratch.path("next-1.new"));
  fs::remove(scratch.path("next-1.new-wal"));
  ASSERT_TRUE(folder.begin(header, 1, one_event()));
  replace(run_file_of(scratch.path(), 1));
  EXPECT_EQ(folder.write(one_event()).error(), "was replaced while it was written");
}

TEST(AFileAtTheNameOfARun, IsNotTakenForTheRunThatACrashLeftAtItsFirstName) {
  const Scratch scratch, before;
  ASSERT_EQ(record_and_crash(scratch.path(), before.path(), 1, 0), "");
  give_first_name(scratch.path(), 1);
  const std::string file = foreign_file(scratch);
  RunFolder folder(folder_options(scratch.path()));
  const auto opened = folder.open();
  ASSERT_FALSE(opened);
  EXPECT_NE(opened.error().find(fs::path(file).filename().string()), std::string::npos) << opened.error();
  EXPECT_EQ(Scratch::read(file), "foreign");
  EXPECT_TRUE(fs::exists(scratch.path("next-1.new"))) << "the run";
  EXPECT_FALSE(fs::exists(file + "-wal")) << "the run's log is no log of that file";
}

}  // namespace
}  // namespace dwell::record
