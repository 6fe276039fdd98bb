#include "daemon/record/regular_file.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

#include "daemon/record/audit.hpp"
#include "daemon/record/disk_reserve.hpp"
#include "daemon/record/run_list.hpp"
#include "daemon/record/small_file.hpp"
#include "tests/record/altered_files.hpp"

namespace dwell::record {
namespace {

// Whoever waits for the pipe's other end is ended by the system instead of holding up all tests.
struct NamedPipe : testing::Test {
  NamedPipe() { ::alarm(60); }
  ~NamedPipe() override { ::alarm(0); }
  std::string pipe(const std::string& name) const {
    EXPECT_EQ(::mkfifo(scratch.path(name).c_str(), 0644), 0);
    return scratch.path(name);
  }
  const Scratch scratch;
};

TEST_F(NamedPipe, InPlaceOfARunIsNamedAndNotWaitedFor) {
  const std::string path = pipe("rig-1-20260101T000000Z.dwell");
  const auto read = ChainReader::open(path, ChainSort::run);
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error(), path + ": is no regular file");
  const auto audit = audit_run(path, {});
  ASSERT_FALSE(audit);
  EXPECT_EQ(audit.error(), path + ": is no file");
}

TEST_F(NamedPipe, InPlaceOfAWalIsNamedByAuditAndBySigner) {
  const std::string path = scratch.path("a.dwell");
  write_sample(path, {});
  const std::string wal = pipe("a.dwell-wal");
  const auto audit = audit_run(path, {});
  ASSERT_TRUE(audit) << audit.error();
  EXPECT_EQ(audit->state, AuditState::tampered);
  EXPECT_EQ(audit->where, wal + ": is no regular file");
  const auto writer = ChainWriter::open(path, ChainSort::run, "dwell/run/", sample_key());
  ASSERT_FALSE(writer);
  EXPECT_EQ(writer.error(), wal + ": is no regular file");
}

TEST_F(NamedPipe, HidesNoOtherRunFromTheList) {
  write_sample(scratch.path("rig-1-20260101T000000Z.dwell"), {});
  (void)pipe("rig-2-20260101T000000Z.dwell");
  std::vector<std::string> found;
  look_at_runs(
      scratch.path(), "", [&](const ListedRun& run) { found.push_back(run.file + " " + run.state); },
      [] { return false; });
  EXPECT_EQ(found, (std::vector<std::string>{"rig-2-20260101T000000Z.dwell unreadable",
                                             "rig-1-20260101T000000Z.dwell closed"}));
}

TEST_F(NamedPipe, InPlaceOfASmallFileAKeyOrTheReserveIsRefused) {
  const std::string path = pipe("other");
  const std::string refusal = path + ": is no regular file";
  EXPECT_EQ(read_small_file(path).error(), refusal);
  EXPECT_EQ(append_line(path, "x").error(), refusal);
  EXPECT_EQ(SigningKey::load(path).error(), refusal);
  EXPECT_EQ(DiskReserve(path, 4096).hold().error(), refusal);
}

// A full disk had cut the line before: the next one was glued to it, and both were lost.
TEST(SmallFile, ALineIsAppendedAsALineOfItsOwn) {
  const Scratch scratch;
  const std::string path = scratch.write("heads", "one\ntw");
  ASSERT_TRUE(append_line(path, "three"));
  ASSERT_TRUE(append_line(path, "four"));
  EXPECT_EQ(Scratch::read(path), "one\ntw\nthree\nfour\n");
}

TEST(RegularFile, AFullDiskAndAFullQuotaReadAlike) {
  EXPECT_EQ(system_text(ENOSPC), "disk full");
  EXPECT_EQ(system_text(EDQUOT), "disk full");
  EXPECT_EQ(system_text(EACCES), "Permission denied");
}

TEST(RunList, SaysOfAFileThatItIsALink) {
  const Scratch scratch;
  const std::string first = "rig-1-20260101T000000Z.dwell", second = "rig-2-20260101T000000Z.dwell";
  write_sample(scratch.path(first), {});
  ASSERT_EQ(::symlink(scratch.path(first).c_str(), scratch.path(second).c_str()), 0);
  EXPECT_FALSE(look_at_run(scratch.path(), first).linked);
  EXPECT_TRUE(look_at_run(scratch.path(), second).linked);
  EXPECT_EQ(look_at_run(scratch.path(), second).state, "closed");
}

TEST(RegularFile, ALinkToAFileIsOpenedAndADirectoryIsNot) {
  const Scratch scratch;
  const std::string file = scratch.write("file", "x"), link = scratch.path("link");
  ASSERT_EQ(::symlink(file.c_str(), link.c_str()), 0);
  EXPECT_TRUE(open_regular(link));
  EXPECT_EQ(open_regular(scratch.path()).error(), scratch.path() + ": is no regular file");
  const auto none = open_regular_if_there(scratch.path("none"));
  EXPECT_TRUE(none && !*none);
}

}  // namespace
}  // namespace dwell::record
