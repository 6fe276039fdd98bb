#include "daemon/record/run_folder.hpp"

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>

#include "daemon/record/audit.hpp"
#include "daemon/record/chain_file.hpp"
#include "daemon/record/file_name.hpp"
#include "daemon/record/key_file.hpp"
#include "daemon/record/run_list.hpp"
#include "daemon/record/run_reader.hpp"
#include "tests/record/child.hpp"
#include "tests/record/recorded_rig.hpp"
#include "tests/record/scratch.hpp"
#include "tests/record/synthetic_stream.hpp"

namespace dwell::record {
namespace {

constexpr std::int64_t kStart_utc_ns = 1'790'000'000'000'000'000;

// The service's recording in one thread and virtual time, on a real disk.
struct FolderRig {
  explicit FolderRig(const std::string& directory)
      : folder(folder_options(directory)),
        log(folder, log_options(notices)),
        stream(2, 1000.0, [this](const Record& r) {
          log.set_clock({r.t_ns, kStart_utc_ns + r.t_ns});
          log.record(r);
          log.caught_up();
        }) {
    EXPECT_TRUE(folder.open());
  }

  // 2.5 s, half a second after its pipeline was armed, and what closes it.
  void record_a_run() {
    stream.armed();
    stream.play(0.5);
    stream.begins();
    stream.play(2.5);
    stream.ends();
    stream.play(1.5);
  }

  Notices notices;
  RunFolder folder;
  RunLog log;
  SyntheticStream stream;
};

std::vector<std::string> run_files(const std::string& directory) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(directory))
    if (run_of_file_name(entry.path().filename().string()) > 0) names.push_back(entry.path().string());
  std::sort(names.begin(), names.end());
  return names;
}

std::string ledger_of(const std::string& directory) { return directory + "/ledger.dwell-ledger"; }

Audit audited(const std::string& path) {
  const auto audit = audit_run(path, {});
  EXPECT_TRUE(audit) << audit.error();
  return audit.value_or(Audit());
}

std::string broken(const std::string& directory) {
  const auto audit = audit_ledger(ledger_of(directory), directory, {});
  if (!audit) return audit.error();
  std::string text = audit->where;
  for (const std::string& missing : audit->missing) text += " missing: " + missing;
  return audit->unbroken ? text : "broken: " + text;
}

TEST(RunFolder, RunsAreFilesOfTheirOwnThatAuditAsIntactAndTheLedgerKnowsThem) {
  const Scratch scratch;
  FolderRig rig(scratch.path());
  for (int run = 0; run < 3; ++run) rig.record_a_run();
  rig.folder.settle();
  const auto files = run_files(scratch.path());
  ASSERT_EQ(files.size(), 3u) << rig.notices.text();
  EXPECT_EQ(std::filesystem::path(files[0]).filename().string().substr(0, 8), "bench-1-");
  for (const std::string& file : files) {
    EXPECT_EQ(audited(file).state, AuditState::intact) << audited(file).where;
    EXPECT_FALSE(std::filesystem::exists(file + "-wal"));
  }
  EXPECT_EQ(broken(scratch.path()), "");
  const ListedRun listed = look_at_run(scratch.path(), std::filesystem::path(files[2]).filename().string());
  EXPECT_EQ(listed.run, 3);
  EXPECT_EQ(listed.state, "closed");
  EXPECT_EQ(listed.samples, 6000u);
  EXPECT_EQ(listed.head.size(), 64u);
}

// Whoever opens it tells what a crash left there; a run would not.
TEST(RunFolder, ARunBeginsInAnOpenFolderOnly) {
  const Scratch scratch;
  RunFolder folder(folder_options(scratch.path()));
  RunHeader header = rig_header();
  header.start_utc = "2026-11-23T00:00:00Z";
  EXPECT_EQ(folder.begin(header, 0, {}).error(), scratch.path() + " is not open yet");
  ASSERT_TRUE(folder.open());
  EXPECT_TRUE(folder.begin(header, 0, {}));
}

// While the service lives, its ledger is in use; people copy the file by itself.
TEST(RunFolder, ACopyOfTheLedgerAloneKnowsTheRunsThatHaveEnded) {
  const Scratch scratch, elsewhere;
  FolderRig rig(scratch.path());
  rig.record_a_run();
  rig.folder.settle();
  const std::string copy = elsewhere.path("ledger.dwell-ledger");
  std::filesystem::copy_file(ledger_of(scratch.path()), copy);
  const auto audit = audit_ledger(copy, scratch.path(), {});
  ASSERT_TRUE(audit) << audit.error();
  EXPECT_TRUE(audit->unbroken) << audit->where;
  const auto files = run_files(scratch.path());
  ASSERT_EQ(files.size(), 1u);
  AuditOptions options;
  options.ledger = copy;
  EXPECT_EQ(audit_run(files[0], options)->state, AuditState::intact) << audit_run(files[0], options)->where;
}

TEST(RunFolder, ARunWhoseDwellsCannotBeReadIsListedAsUnreadable) {
  const Scratch scratch;
  RunFolder folder(folder_options(scratch.path()));
  ASSERT_TRUE(folder.ready());
  RunHeader header = rig_header();
  header.start_utc = "2026-11-23T00:00:00Z";
  const std::vector<NewEntry> damaged{{"result", 2, "no JSON"}};
  ASSERT_TRUE(folder.begin(header, 1, damaged));
  const ListedRun listed = look_at_run(scratch.path(), folder.file());
  EXPECT_EQ(listed.state, "unreadable") << "not: cut off, with " << listed.dwells << " dwells";
  EXPECT_EQ(listed.run, 1);
}

TEST(RunFolder, TheNextStartTellsOfARunThatWasCutOffAndAltersNoByteOfIt) {
  const Scratch scratch;
  // A crash: the process ends without another word.
  EXPECT_EQ(in_child([&] {
              FolderRig rig(scratch.path());
              rig.stream.starts();
              rig.stream.play(4.5);
              vanish();
              return std::string();
            }),
            "");
  const auto files = run_files(scratch.path());
  ASSERT_EQ(files.size(), 1u);
  const std::string file = Scratch::read(files[0]), wal = Scratch::read(files[0] + "-wal");
  ASSERT_FALSE(wal.empty());
  RunFolder folder(folder_options(scratch.path()));
  ASSERT_TRUE(folder.open());
  const auto cut_off = folder.take_cut_off();
  ASSERT_TRUE(cut_off);
  EXPECT_EQ(cut_off->run, 1);
  EXPECT_EQ(scratch.path(cut_off->file), files[0]);
  const double until_s = static_cast<double>(parse_utc(cut_off->until_utc).value() - kStart_utc_ns) * 1e-9;
  EXPECT_NEAR(until_s, 5.0, 0.1) << "the fourth block of a stream that began at 1 s";
  EXPECT_FALSE(folder.take_cut_off()) << "once";
  EXPECT_EQ(Scratch::read(files[0]), file);
  EXPECT_EQ(Scratch::read(files[0] + "-wal"), wal);
  EXPECT_EQ(audited(files[0]).state, AuditState::open);
  EXPECT_EQ(broken(scratch.path()), "");
}

TEST(RunFolder, OneServiceAtATimeRecordsIntoADirectory) {
  const Scratch scratch;
  RunFolder first(folder_options(scratch.path()));
  ASSERT_TRUE(first.open());
  RunFolder second(folder_options(scratch.path()));
  EXPECT_EQ(second.open().error(), scratch.path() + ": another dwelld records here");
  EXPECT_EQ(change_key(scratch.path(), "dwell-bench").error(), scratch.path() + ": another dwelld records here");
}

TEST(RunFolder, ADirectoryThatCannotBeUsedIsNamed) {
  RunFolder folder(folder_options("/proc/nowhere"));
  EXPECT_EQ(folder.ready().error().substr(0, 15), "/proc/nowhere: ");
}

TEST(RunFolder, ADeletedRunIsToldToTheLedgerAndNotMissing) {
  const Scratch scratch;
  FolderRig rig(scratch.path());
  rig.stream.starts();
  rig.stream.play(1.5);
  rig.log.finish();
  rig.folder.settle();
  const auto files = run_files(scratch.path());
  const ListedRun listed = look_at_run(scratch.path(), std::filesystem::path(files[0]).filename().string());
  ASSERT_TRUE(rig.folder.run_deleted(listed.run, "older than 400 days").get());
  std::filesystem::remove(files[0]);
  EXPECT_EQ(broken(scratch.path()), "");
}

void write_line(const char* path, const std::string& line) { std::ofstream(path) << line; }

// A small disk, in a namespace of its own: nothing outside sees it. What kept it from being; empty: it is there.
std::string mount_small_disk(const std::string& at, int kilobytes) {
  const std::string uid = std::to_string(getuid()), gid = std::to_string(getgid());
  if (unshare(getuid() == 0 ? CLONE_NEWNS : CLONE_NEWUSER | CLONE_NEWNS) != 0) return "no namespaces";
  if (uid != "0") {
    write_line("/proc/self/setgroups", "deny");
    write_line("/proc/self/uid_map", uid + " " + uid + " 1");
    write_line("/proc/self/gid_map", gid + " " + gid + " 1");
  }
  if (mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0) return "mounts are shared";
  const std::string size = "size=" + std::to_string(kilobytes) + "k";
  return mount("none", at.c_str(), "tmpfs", 0, size.c_str()) == 0 ? "" : "no tmpfs";
}

std::string record_until_full(const std::string& directory) {
  if (const std::string cannot = mount_small_disk(directory, 6'000); !cannot.empty()) return "skip: " + cannot;
  FolderRig rig(directory);
  rig.stream.starts();
  // A file that fills what is left over.
  rig.stream.play(3.0);
  const std::string ballast = directory + "/ballast";
  std::ofstream(ballast) << std::string(8'000'000, 'x');
  rig.stream.play(600.0);
  rig.folder.settle();
  if (rig.log.stopped().empty()) return "it did not notice";
  if (rig.log.stopped().find("disk full") == std::string::npos) return "another reason: " + rig.log.stopped();
  const auto files = run_files(directory);
  if (files.size() != 1) return "files: " + std::to_string(files.size());
  const auto audit = audit_run(files[0], {});
  if (!audit || audit->state != AuditState::intact) return "not closed: " + (audit ? audit->where : audit.error());
  const auto reader = RunReader::open(files[0]);
  if (!reader || !reader->end() || reader->end()->why != "disk full") return "no reason in it";
  if (rig.folder.ready()) return "a full disk is said to be ready";
  std::filesystem::remove(ballast);
  if (const auto ready = rig.folder.ready(); !ready) return "not ready again: " + ready.error();
  rig.stream.ends();
  rig.stream.starts();
  rig.stream.play(2.0);
  rig.log.finish();
  rig.folder.settle();
  if (run_files(directory).size() != 2) return "it did not go on: " + rig.log.stopped();
  return broken(directory);
}

TEST(RunFolder, AFullDiskEndsTheRunWithAllItsClosingEntriesAndTheNextBeginsWhenThereIsRoom) {
  const Scratch scratch;
  const std::string said = in_child([&] { return record_until_full(scratch.path()); });
  if (said.substr(0, 4) == "skip") GTEST_SKIP() << said;
  EXPECT_EQ(said, "");
}

TEST(KeyFile, IsMadeOnceForTheServiceAloneWithItsPublicPartBesideIt) {
  const Scratch scratch;
  std::string vkey;
  {
    const auto made = open_key_and_ledger(scratch.path(), "dwell-bench");
    ASSERT_TRUE(made) << made.error();
    EXPECT_TRUE(made->made);
    vkey = made->key.public_key().vkey();
  }
  struct stat status {};
  ASSERT_EQ(stat(scratch.path("key").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0600u);
  EXPECT_EQ(Scratch::read(scratch.path("key.pub")), vkey + "\n");
  std::filesystem::remove(scratch.path("key.pub"));
  const auto again = open_key_and_ledger(scratch.path(), "another name");
  ASSERT_TRUE(again) << again.error();
  EXPECT_FALSE(again->made);
  EXPECT_EQ(again->key.public_key().vkey(), vkey);
  EXPECT_EQ(Scratch::read(scratch.path("key.pub")), vkey + "\n") << "written again";
}

TEST(KeyFile, AnotherKeySignsAfterAChangeAndTheLedgerSaysSo) {
  const Scratch scratch;
  const auto record_a_run = [&] {
    FolderRig rig(scratch.path());
    rig.stream.starts();
    rig.stream.play(1.5);
    rig.log.finish();
  };
  record_a_run();
  const std::string before = Scratch::read(scratch.path("key.pub"));
  const auto changed = change_key(scratch.path(), "dwell-bench");
  ASSERT_TRUE(changed) << changed.error();
  EXPECT_EQ(Scratch::read(scratch.path("key.pub")), changed->vkey() + "\n");
  EXPECT_NE(changed->vkey() + "\n", before);
  EXPECT_FALSE(std::filesystem::exists(scratch.path("key.next")));
  record_a_run();
  EXPECT_EQ(broken(scratch.path()), "");
  const auto files = run_files(scratch.path());
  ASSERT_EQ(files.size(), 2u);
  EXPECT_EQ(audited(files[0]).state, AuditState::intact);
  EXPECT_EQ(audited(files[1]).state, AuditState::intact);
  EXPECT_NE(audited(files[0]).key, audited(files[1]).key);
}

TEST(KeyFile, AChangeThatWasCutOffIsCompletedOrNeverWas) {
  const Scratch scratch;
  std::string vkey;
  {
    const auto made = open_key_and_ledger(scratch.path(), "dwell-bench");
    ASSERT_TRUE(made);
    vkey = made->key.public_key().vkey();
  }
  // Cut off before the ledger knew: the old key signs, the other is gone.
  const auto next = SigningKey::make("dwell-bench");
  ASSERT_TRUE(next && next->save(scratch.path("key.next")));
  {
    const auto opened = open_key_and_ledger(scratch.path(), "dwell-bench");
    ASSERT_TRUE(opened) << opened.error();
    EXPECT_EQ(opened->key.public_key().vkey(), vkey);
    EXPECT_FALSE(std::filesystem::exists(scratch.path("key.next")));
  }
  // Cut off after the ledger knew: the next key signs.
  {
    auto opened = open_key_and_ledger(scratch.path(), "dwell-bench");
    ASSERT_TRUE(next->save(scratch.path("key.next")));
    ASSERT_TRUE(opened->ledger.key_changes(next->public_key()));
  }
  const auto opened = open_key_and_ledger(scratch.path(), "dwell-bench");
  ASSERT_TRUE(opened) << opened.error();
  EXPECT_EQ(opened->key.public_key(), next->public_key());
  EXPECT_EQ(Scratch::read(scratch.path("key.pub")), next->public_key().vkey() + "\n");
}

}  // namespace
}  // namespace dwell::record
