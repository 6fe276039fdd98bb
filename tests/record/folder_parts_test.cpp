// The small parts of the recording directory: names, reserve, retention, anchors, the thread beside.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <pthread.h>
#include <sys/stat.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <future>
#include <memory>
#include <system_error>
#include <thread>

#include "daemon/record/anchor_delivery.hpp"
#include "daemon/record/disk_jobs.hpp"
#include "daemon/record/disk_reserve.hpp"
#include "daemon/record/file_name.hpp"
#include "daemon/record/job_thread.hpp"
#include "daemon/record/kept_jobs.hpp"
#include "daemon/record/prepared_runs.hpp"
#include "daemon/record/retention.hpp"
#include "daemon/record/utc_text.hpp"
#include "tests/record/scratch.hpp"

namespace dwell::record {
namespace {

constexpr std::int64_t kDay_ns = 86'400'000'000'000;

TEST(RunFileName, TellsRigRunAndInstantAndNothingThatAShellOrPathMinds) {
  EXPECT_EQ(run_file_name("suspension bench 2", 17, "20261123T031217Z"),
            "suspension-bench-2-17-20261123T031217Z.dwell");
  EXPECT_EQ(tame("../../etc/passwd"), "etc-passwd");
  EXPECT_EQ(tame("a\nb; rm -rf \"$x\""), "a-b-rm-rf-x");
  EXPECT_EQ(tame("Prüfstand"), "Pr-fstand");
  EXPECT_EQ(tame("§§§"), "rig");
  EXPECT_EQ(tame(".hidden"), "hidden");
  EXPECT_LE(tame(std::string(1000, 'x')).size(), 64u);
}

TEST(RunFileName, IsReadBack) {
  EXPECT_EQ(run_of_file_name(run_file_name("rig-4-b", 17, "20261123T031217Z")), 17);
  for (const char* other : {"ledger.dwell-ledger", "x.dwell", "rig-x-20261123T031217Z.dwell", "rig-17-20261123T031217Z",
                            "rig-17-20261123T031217Z.dwell-wal", "-17-.dwell-", ".dwell", ""})
    EXPECT_EQ(run_of_file_name(other), 0) << other;
}

TEST(UtcText, IsReadBack) {
  const std::int64_t instant_ns = 1'795'403'537'250'000'000;
  EXPECT_EQ(iso_utc(instant_ns), "2026-11-23T03:12:17.250000Z");
  EXPECT_EQ(compact_utc(iso_utc(instant_ns)), "20261123T031217Z");
  EXPECT_EQ(parse_utc(iso_utc(instant_ns)).value(), instant_ns);
  EXPECT_EQ(parse_utc("2026-11-23T03:12:17Z").value(), instant_ns - 250'000'000);
  EXPECT_EQ(iso_utc(-1'000), "1969-12-31T23:59:59.999999Z");
  for (const char* last : {"1824-01-01T00:00:00.000000Z", "2115-12-31T23:59:59.999999Z"})
    EXPECT_EQ(iso_utc(parse_utc(last).value()), last);
  for (const char* wrong : {"", "2026-11-23", "2026-11-23T03:12:17", "2026-11-23T03:12:17.25", "2026-11-23T03:12:17Zx",
                            "1823-01-01T00:00:00Z", "2117-01-01T00:00:00Z", "9999-12-31T23:59:59.999Z"})
    EXPECT_FALSE(parse_utc(wrong)) << wrong;
}

// While it lives the system gives no thread: none has room for its stack.
class NoThreads {
 public:
  NoThreads() {
    pthread_getattr_default_np(&usual_);
    pthread_attr_t vast;
    pthread_attr_init(&vast);
    pthread_attr_setstacksize(&vast, std::size_t{1} << 60U);
    pthread_setattr_default_np(&vast);
    pthread_attr_destroy(&vast);
  }
  NoThreads(const NoThreads&) = delete;
  NoThreads& operator=(const NoThreads&) = delete;
  ~NoThreads() {
    pthread_setattr_default_np(&usual_);
    pthread_attr_destroy(&usual_);
  }

 private:
  pthread_attr_t usual_{};
};

TEST(DiskJobs, AJobKeepsItsFileAndIsDoneIfTheSystemGivesNoThread) {
  DiskJobs jobs;
  int seen = 0;
  {
    const NoThreads scarce;
    EXPECT_THROW(std::thread([] {}).join(), std::system_error) << "the shortage itself";
    jobs.start([file = std::make_unique<int>(7), &seen]() -> Result<void> {
      seen = file ? *file : -1;
      return tl::unexpected(std::string("disk full"));
    });
    EXPECT_EQ(jobs.take_failures(), std::vector<std::string>{"disk full"}) << "done before start() returns";
  }
  EXPECT_EQ(seen, 7);
}

TEST(KeptJobs, AreDoneInTheirOrderAndOneThatFailsKeepsThoseAfterItUntilItSucceeds) {
  DiskJobs thread;
  KeptJobs jobs(thread);
  std::string done;
  bool full = true;
  jobs.add([&done]() -> Result<void> {
    done += 'a';
    return {};
  });
  jobs.add([&]() -> Result<void> {
    if (full) return tl::unexpected(std::string("disk full"));
    done += 'b';
    return {};
  });
  jobs.add([&done]() -> Result<void> {
    done += 'c';
    return {};
  });
  thread.settle();
  EXPECT_EQ(done, "a");
  EXPECT_EQ(jobs.size(), 2U);
  EXPECT_EQ(jobs.refused(), "disk full");
  full = false;
  jobs.again();
  thread.settle();
  EXPECT_EQ(done, "abc");
  EXPECT_EQ(jobs.size(), 0U);
  EXPECT_EQ(jobs.refused(), "");
  EXPECT_TRUE(thread.take_failures().empty()) << "they are told by refused()";
}

TEST(PreparedRuns, AreMadeAtTheirPathsIfTheSystemGivesNoThread) {
  const Scratch scratch;
  PreparedRuns prepared(scratch.path(""));
  const NoThreads scarce;
  prepared.make(3);
  prepared.wait();
  for (const int run : {3, 4, 5}) EXPECT_TRUE(std::filesystem::exists(prepared.path_of(run))) << prepared.path_of(run);
}

TEST(DiskReserve, HoldsBlocksAndGivesThemFree) {
  const Scratch scratch;
  DiskReserve reserve(scratch.path("reserve"), 1'000'000);
  ASSERT_TRUE(reserve.hold());
  struct stat status {};
  ASSERT_EQ(stat(scratch.path("reserve").c_str(), &status), 0);
  EXPECT_GE(std::int64_t{status.st_blocks} * 512, 1'000'000) << "not sparse";
  ASSERT_TRUE(reserve.hold()) << "once more";
  reserve.release();
  EXPECT_NE(stat(scratch.path("reserve").c_str(), &status), 0);
}

TEST(DiskReserve, IsMadeAnewWhereSomebodyCutIt) {
  const Scratch scratch;
  scratch.write("reserve", "short");
  DiskReserve reserve(scratch.path("reserve"), 1'000'000);
  ASSERT_TRUE(reserve.hold());
  EXPECT_EQ(std::filesystem::file_size(scratch.path("reserve")), 1'000'000u);
}

TEST(DiskReserve, SaysWhatKeepsItFromItsRoom) {
  DiskReserve reserve("/nowhere/reserve", 1'000'000);
  EXPECT_EQ(reserve.hold().error(), "/nowhere/reserve: No such file or directory");
}

ListedRun ended(std::int64_t run, std::int64_t days_ago, std::uint64_t bytes) {
  ListedRun listed;
  listed.run = run;
  listed.file = "rig-" + std::to_string(run) + "-20260101T000000Z.dwell";
  listed.state = "closed";
  listed.ended_utc = iso_utc(1'000 * kDay_ns - days_ago * kDay_ns);
  listed.bytes = bytes;
  listed.clock_synchronized = true;
  return listed;
}

std::vector<std::int64_t> deleted(const ListedRuns& runs, const RetentionPolicy& policy) {
  std::vector<std::int64_t> numbers;
  for (const Deletion& deletion : choose_deletions(runs, policy, 1'000 * kDay_ns)) numbers.push_back(deletion.run.run);
  return numbers;
}

TEST(Retention, DeletesNothingUnasked) {
  EXPECT_EQ(deleted({ended(1, 900, 1'000'000'000'000)}, {}), std::vector<std::int64_t>());
}

TEST(Retention, DeletesByAgeOfTheEnd) {
  const ListedRuns runs{ended(1, 401, 1), ended(2, 399, 1), ended(3, 0, 1)};
  EXPECT_EQ(deleted(runs, {400.0, {}}), std::vector<std::int64_t>{1});
  EXPECT_EQ(choose_deletions(runs, {400.0, {}}, 1'000 * kDay_ns)[0].why, "older than 400 days");
}

// The oldest run, which has no age, went by size although the old ones alone made room enough.
TEST(Retention, DeletesByAgeFirstAndBySizeOnlyWhatIsStillTooMuch) {
  ListedRuns runs{ended(1, 500, 10'000'000'000), ended(2, 450, 90'000'000'000), ended(3, 1, 10'000'000'000)};
  runs[0].clock_synchronized = false;
  EXPECT_EQ(deleted(runs, {400.0, 60.0}), std::vector<std::int64_t>{2});
  EXPECT_EQ(deleted(runs, {400.0, 15.0}), (std::vector<std::int64_t>{2, 1}));
}

TEST(Retention, ARunThatWasRecordedWithoutASynchronizedClockHasNoAge) {
  ListedRuns runs{ended(1, 401, 1), ended(2, 401, 1)};
  runs[0].clock_synchronized = false;
  EXPECT_EQ(deleted(runs, {400.0, {}}), std::vector<std::int64_t>{2});
  runs[0].bytes = 2'000'000'000;
  EXPECT_EQ(deleted(runs, {{}, 1.0}), std::vector<std::int64_t>{1}) << "but it has a size";
}

TEST(Retention, DeletesTheOldestUntilAllFit) {
  const ListedRuns runs{ended(1, 4, 4'000'000'000), ended(2, 3, 4'000'000'000), ended(3, 2, 4'000'000'000)};
  EXPECT_EQ(deleted(runs, {{}, 9.0}), std::vector<std::int64_t>{1});
  EXPECT_EQ(deleted(runs, {{}, 12.0}), std::vector<std::int64_t>());
}

TEST(Retention, NeverDeletesARunThatGoesOnIsProtectedOrCannotBeRead) {
  ListedRuns runs{ended(1, 900, 9'000'000'000), ended(2, 900, 9'000'000'000), ended(3, 900, 9'000'000'000)};
  runs[0].kept = true;
  runs[1].state = "unreadable";
  runs[2].state = "recording";
  EXPECT_EQ(deleted(runs, {1.0, 1.0}), std::vector<std::int64_t>());
  runs[2].ended_utc.clear();
  runs[2].state = "cut off";
  EXPECT_EQ(deleted(runs, {1.0, {}}), std::vector<std::int64_t>()) << "nobody knows how old it is";
}

TEST(AnchorDelivery, AddsALineToTheFileAndGivesItToTheCommand) {
  const Scratch scratch;
  const AnchorTarget target{10.0, scratch.path("heads"), {"tee", "-a", scratch.path("sent away; $x")}};
  ASSERT_TRUE(deliver_anchor(target, "line 1"));
  ASSERT_TRUE(deliver_anchor(target, "line 2"));
  EXPECT_EQ(Scratch::read(scratch.path("heads")), "line 1\nline 2\n");
  EXPECT_EQ(Scratch::read(scratch.path("sent away; $x")), "line 1\nline 2\n") << "no shell has seen the name";
}

TEST(AnchorDelivery, SaysWhatWentWrong) {
  EXPECT_EQ(deliver_anchor({1.0, "/nowhere/heads", {}}, "x").error(), "/nowhere/heads: No such file or directory");
  EXPECT_EQ(deliver_anchor({1.0, {}, {"/nowhere/program"}}, "x").error(),
            "command /nowhere/program: No such file or directory");
  EXPECT_EQ(deliver_anchor({1.0, {}, {"false"}}, "x").error(), "command false: exit status 1");
}

TEST(AnchorDelivery, KillsACommandThatDoesNotEndWithAllThatItStarted) {
  const Scratch scratch;
  const auto began = std::chrono::steady_clock::now();
  const auto done = deliver_anchor({1.0, {}, {"sh", "-c", "sleep 100; true"}}, "x", std::chrono::milliseconds(100));
  EXPECT_EQ(done.error(), "command sh: not done within 0.1 s");
  EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds(20));
}

TEST(JobThread, DoesItsJobsInOrder) {
  JobThread thread("test");
  std::string order;
  std::promise<void> done;
  for (const char c : {'a', 'b', 'c'}) thread.post([&order, c](const auto&) { order += c; });
  thread.post([&done](const auto&) { done.set_value(); });
  done.get_future().wait();
  EXPECT_EQ(order, "abc");
}

TEST(JobThread, TakesNoMoreThanItsJobs) {
  JobThread thread("test");
  std::promise<void> begun, go;
  thread.post([&begun, going = go.get_future().share()](const auto&) {
    begun.set_value();
    going.wait();
  });
  begun.get_future().wait();
  std::size_t taken = 0;
  while (taken <= JobThread::kJobs && thread.post([](const auto&) {})) ++taken;
  EXPECT_EQ(taken, JobThread::kJobs);
  go.set_value();
}

TEST(JobThread, LeavesAJobBehindThatHangs) {
  const auto go = std::make_shared<std::promise<void>>();
  const auto ended = std::make_shared<std::promise<void>>();
  {
    JobThread thread("test");
    std::promise<void> begun;
    thread.post([&begun, going = go->get_future().share(), ended](const auto& stopping) {
      begun.set_value();
      going.wait();
      EXPECT_TRUE(stopping());
      ended->set_value();
    });
    begun.get_future().wait();
  }
  go->set_value();
  ended->get_future().wait();
}

}  // namespace
}  // namespace dwell::record
