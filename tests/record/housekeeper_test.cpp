#include "daemon/record/housekeeper.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <thread>
#include <vector>

#include "daemon/record/file_name.hpp"
#include "daemon/record/key_file.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/signature.hpp"
#include "tests/record/recorded_rig.hpp"
#include "tests/record/scratch.hpp"

namespace dwell::record {
namespace {

constexpr std::int64_t kMidnight_utc_ns = 1'790'000'000'000'000'000;

// A directory that records nothing, whose ledger is anchored to a file every minute. Virtual time.
struct HousekeeperTest : testing::Test {
  HousekeeperTest() : folder(folder_options(scratch.path(""))) {}

  // set_days: by which somebody has set the clock.
  void turn(double t_s, double set_days = 0.0) {
    const auto t_ns = static_cast<std::int64_t>(t_s * 1e9);
    keeper->turn({t_ns, kMidnight_utc_ns + t_ns + static_cast<std::int64_t>(set_days * 86'400e9)},
                 recorded.file.empty() ? nullptr : &recorded);
  }
  // Turns within one instant until what the jobs' thread has done is known here.
  void turn_until(double t_s, const std::function<bool()>& known, double set_days = 0.0) {
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(30);
    do {
      ASSERT_LT(std::chrono::steady_clock::now(), until) << "never known";
      turn(t_s, set_days);
      std::this_thread::yield();
    } while (!known());
  }

  // A run that begins and ends at midnight. follows: another one begins at once.
  RunHeader record_run(bool follows) { return record_run_in(folder, follows); }
  static RunHeader record_run_in(RunFolder& to, bool follows) {
    RunHeader header = rig_header();
    header.start_utc = iso_utc(kMidnight_utc_ns);
    EXPECT_TRUE(to.begin(header, 0, {}));
    const std::vector<NewEntry> last{{"end", 0, to_json(RunEnd{"operator", 0, 0, header.start_utc})}};
    EXPECT_TRUE(to.end(last));
    if (!follows) to.settle();
    return header;
  }
  // Whether the anchor of the run's last entry has arrived.
  [[nodiscard]] bool sent(const RunHeader& run) const {
    return Scratch::read(heads).find("dwell/run/" + run.id + " 2 ") != std::string::npos;
  }

  Scratch scratch;
  const std::string heads = scratch.path("share/heads");
  Notices notices;
  RunFolder folder;
  ListedRun recorded;  // no file: none is recorded
  std::unique_ptr<Housekeeper> keeper;
};

// The share was away when the last run of the day ended: no head changes until the next morning.
TEST_F(HousekeeperTest, AnAnchorThatDidNotArriveIsSentAgainWhenTheNextIsDue) {
  ASSERT_TRUE(folder.open());
  keeper = std::make_unique<Housekeeper>(
      HousekeepingOptions{folder_options(scratch.path("")).directory, {}, {1.0, heads, {}}}, folder,
      std::make_shared<RunList>(), notices.tell());
  turn_until(0.0, [&] { return !keeper->anchor_trouble().empty(); });
  EXPECT_EQ(keeper->anchor_trouble(), heads + ": No such file or directory");
  std::filesystem::create_directory(scratch.path("share"));
  turn_until(60.0, [&] { return keeper->anchor_trouble().empty(); });
  EXPECT_NE(Scratch::read(heads).find("dwell/ledger/"), std::string::npos);
}

// Somebody starts and stops more quickly than the recorder's thread turns.
TEST_F(HousekeeperTest, RunsThatBeginAndEndBetweenTwoTurnsAreListedAndAnchored) {
  ASSERT_TRUE(folder.open());
  std::filesystem::create_directory(scratch.path("share"));
  const auto list = std::make_shared<RunList>();
  keeper = std::make_unique<Housekeeper>(
      HousekeepingOptions{folder_options(scratch.path("")).directory, {}, {1.0, heads, {}}}, folder, list,
      notices.tell());
  turn_until(0.0, [&] { return std::filesystem::exists(heads); });
  const std::vector<RunHeader> runs{record_run(true), record_run(true), record_run(false)};
  turn_until(0.5, [&] { return list->all()->size() == 3; });
  for (const RunHeader& run : runs) turn_until(0.5, [&] { return sent(run); });
}

// It stood there as recorded, for as long as the ledger's disk was slow.
TEST_F(HousekeeperTest, ARunThatHasEndedIsListedAsEndingUntilItsFileIsClosed) {
  ASSERT_TRUE(folder.open());
  const auto list = std::make_shared<RunList>();
  keeper = std::make_unique<Housekeeper>(HousekeepingOptions{folder_options(scratch.path("")).directory, {}, {}},
                                         folder, list, notices.tell());
  const std::string ledger = ledger_in(scratch.path()), away = scratch.path("away");
  folder.settle();
  std::filesystem::rename(ledger, away);
  RunHeader header = rig_header();
  header.start_utc = iso_utc(kMidnight_utc_ns);
  ASSERT_TRUE(folder.begin(header, 0, {}));
  recorded.file = folder.file();
  recorded.state = "recording";
  recorded.label = "oil film";
  turn_until(0.0, [&] { return list->all()->size() == 1; });
  recorded.label = "dry";
  turn(0.0);
  EXPECT_EQ(list->all()->front().label, "dry");
  ASSERT_TRUE(folder.end(std::vector<NewEntry>{{"end", 0, to_json(RunEnd{"operator", 0, 0, header.start_utc})}}));
  recorded = {};
  for (int i = 0; i < 3; ++i) turn(0.0);
  EXPECT_EQ(list->all()->front().state, "ending");
  std::filesystem::rename(away, ledger);
  folder.settle();
  turn_until(0.0, [&] { return list->all()->front().state == "closed"; });
}

// Else whoever removes the file and the ledger's tail before the next anchor removes the run without a trace.
TEST_F(HousekeeperTest, ARunThatHasBegunIsAnchoredAsSoonAsTheLedgerKnowsIt) {
  ASSERT_TRUE(folder.open());
  std::filesystem::create_directory(scratch.path("share"));
  keeper = std::make_unique<Housekeeper>(
      HousekeepingOptions{folder_options(scratch.path("")).directory, {}, {1.0, heads, {}}}, folder,
      std::make_shared<RunList>(), notices.tell());
  turn_until(0.0, [&] { return std::filesystem::exists(heads); });
  RunHeader header = rig_header();
  header.start_utc = iso_utc(kMidnight_utc_ns);
  ASSERT_TRUE(folder.begin(header, 0, {}));
  recorded.file = folder.file();
  turn_until(0.5, [&] { return Scratch::read(heads).find("dwell/run/" + header.id + " 1 ") != std::string::npos; });
}

// Each run that ends tells its last head once, and the share was away just then.
TEST_F(HousekeeperTest, TheAnchorOfARunThatEndedIsSentAgainAlthoughOthersHaveFollowed) {
  ASSERT_TRUE(folder.open());
  keeper = std::make_unique<Housekeeper>(
      HousekeepingOptions{folder_options(scratch.path("")).directory, {}, {1.0, heads, {}}}, folder,
      std::make_shared<RunList>(), notices.tell());
  const std::vector<RunHeader> runs{record_run(true), record_run(true), record_run(false)};
  turn_until(0.0, [&] { return !keeper->anchor_trouble().empty(); });
  std::filesystem::create_directory(scratch.path("share"));
  turn_until(60.0, [&] { return keeper->anchor_trouble().empty(); });
  for (const RunHeader& run : runs) EXPECT_TRUE(sent(run)) << run.id;
}

// Somebody removed the ledger while the service was down. The one that begins anew counts from 1 again: a deletion
// would be entered for another run of the same number.
TEST_F(HousekeeperTest, RunsThatTheLedgerDoesNotKnowAreNamedAndNeverDeleted) {
  {
    RunFolder before(folder_options(scratch.path("")));
    ASSERT_TRUE(before.open());
    record_run_in(before, true);
    record_run_in(before, false);
    before.settle();
  }
  for (const char* part : {"", "-wal", "-shm"})
    std::filesystem::remove(scratch.path("ledger.dwell-ledger" + std::string(part)));
  ASSERT_TRUE(folder.open());
  RunHeader next = rig_header();
  next.start_utc = iso_utc(kMidnight_utc_ns + 60'000'000'000);
  ASSERT_TRUE(folder.begin(next, 0, {}));
  ASSERT_TRUE(folder.end(std::vector<NewEntry>{{"end", 0, to_json(RunEnd{"operator", 0, 0, next.start_utc})}}));
  folder.settle();

  HousekeepingOptions options{folder_options(scratch.path("")).directory, {400.0, {}}, {}};
  options.clock_synchronized = [] { return true; };
  const auto list = std::make_shared<RunList>();
  keeper = std::make_unique<Housekeeper>(options, folder, list, notices.tell());
  turn_until(
      0.0, [&] { return notices.hold(" deleted, "); }, 401.0);
  EXPECT_TRUE(notices.hold("runs that the ledger does not know: 2, the last of them ")) << notices.text();
  ASSERT_EQ(list->all()->size(), 2U) << "more than the ledger's own run is deleted";
  EXPECT_EQ(list->all()->front().run, 1);
  EXPECT_EQ(list->all()->back().run, 2);
}

// The first delivery fails after the second was posted: it had been held to hold all heads, and arrived.
TEST_F(HousekeeperTest, AHeadWhoseDeliveryFailedIsInTheOneThatWasUnderWayWithIt) {
  ASSERT_TRUE(folder.open());
  AnchorSender sender({1.0, heads, {}}, folder, notices.tell());
  const RunHeader first = record_run(false);
  sender.turn({0, kMidnight_utc_ns}, folder.take_ended(), true);
  EXPECT_TRUE(sender.wait(std::chrono::seconds(30)));
  std::filesystem::create_directory(scratch.path("share"));
  const RunHeader second = record_run(false);
  sender.turn({1, kMidnight_utc_ns}, folder.take_ended(), true);
  EXPECT_TRUE(sender.wait(std::chrono::seconds(30)));
  sender.take_outcomes({2, kMidnight_utc_ns});
  EXPECT_EQ(sender.trouble(), "");
  EXPECT_TRUE(sent(first));
  EXPECT_TRUE(sent(second));
}

// A share that does not answer: nobody knew until 256 deliveries waited.
TEST_F(HousekeeperTest, AnAnchorThatIsUnderWayForAMinuteIsATrouble) {
  ASSERT_TRUE(folder.open());
  const std::string go_on = scratch.path("go on");
  AnchorSender sender({1.0, {}, {"/bin/sh", "-c", "until [ -e '" + go_on + "' ]; do sleep 0.01; done"}}, folder,
                      notices.tell());
  sender.turn({0, kMidnight_utc_ns}, {}, true);
  sender.take_outcomes({AnchorSender::kLate_ns, kMidnight_utc_ns});
  EXPECT_EQ(sender.trouble(), "");
  sender.take_outcomes({AnchorSender::kLate_ns + 1, kMidnight_utc_ns});
  EXPECT_EQ(sender.trouble(), "not delivered within 60 s");
  scratch.write("go on", "");
  EXPECT_TRUE(sender.wait(std::chrono::seconds(30)));
  sender.take_outcomes({AnchorSender::kLate_ns + 2, kMidnight_utc_ns});
  EXPECT_EQ(sender.trouble(), "");
}

// Three closed runs in a list, and a limit that one deletion keeps: all together are half a run too large.
struct RetentionBySizeTest : HousekeeperTest {
  RetentionBySizeTest() {
    EXPECT_TRUE(folder.open());
    for (int i = 0; i < 3; ++i) record_run(false);
    std::uint64_t bytes = 0;
    look_at_runs(
        scratch.path(), "",
        [&](const ListedRun& run) {
          bytes += run.bytes;
          list->put(run);
        },
        [] { return false; });
    RetentionPolicy policy;
    policy.gigabytes = static_cast<double>(bytes) * 0.8e-9;
    deleter.emplace(RetentionOptions{scratch.path(), policy, [] { return true; }}, folder, list, jobs, notices.tell());
  }
  // The numbers of the runs in the list.
  [[nodiscard]] std::vector<std::int64_t> listed() const {
    std::vector<std::int64_t> numbers;
    for (const ListedRun& run : *list->all()) numbers.push_back(run.run);
    return numbers;
  }

  const std::shared_ptr<RunList> list = std::make_shared<RunList>();
  JobThread jobs{"runs"};
  std::optional<RunDeleter> deleter;
};

// Somebody protects the oldest after it was listed: its bytes counted as freed, and nothing was deleted.
TEST_F(RetentionBySizeTest, InPlaceOfARunThatIsProtectedMeanwhileTheNextOneIsDeleted) {
  scratch.write(list->all()->front().file + std::string(kKeepSuffix), "");
  deleter->turn({0, kMidnight_utc_ns}, nullptr, false);
  EXPECT_EQ(list->all()->size(), 3U) << "the ledger is told first";
  folder.settle();
  deleter->turn({1, kMidnight_utc_ns}, nullptr, false);
  ASSERT_TRUE(jobs.settle(std::chrono::seconds(30)));
  deleter->take_outcomes();
  EXPECT_TRUE(notices.hold("-2-")) << notices.text();
  EXPECT_EQ(listed(), (std::vector<std::int64_t>{1, 3}));
}

// While the ledger was told of the oldest run, the next look chose another one, although the first sufficed.
TEST_F(RetentionBySizeTest, NoMoreRunsAreDeletedThanMustBeWhereALookComesWhileTheLedgerIsTold) {
  for (int i = 0; i < 2; ++i) deleter->turn({i, kMidnight_utc_ns}, nullptr, true);
  for (int i = 2; i < 6; ++i) {
    folder.settle();
    deleter->turn({i, kMidnight_utc_ns}, nullptr, true);
    ASSERT_TRUE(jobs.settle(std::chrono::seconds(30)));
  }
  EXPECT_EQ(listed(), (std::vector<std::int64_t>{2, 3}));
}

// A run that ended at midnight, a limit of 400 days, and a clock that can be set.
struct RetentionByAgeTest : HousekeeperTest {
  RetentionByAgeTest() {
    EXPECT_TRUE(folder.open());
    record_run(false);
    folder.settle();
    HousekeepingOptions options{folder_options(scratch.path("")).directory, {400.0, {}}, {}};
    options.clock_synchronized = [this] { return synchronized; };
    keeper = std::make_unique<Housekeeper>(options, folder, std::make_shared<RunList>(), notices.tell());
  }
  [[nodiscard]] bool deleted() const { return notices.hold(" deleted, "); }

  bool synchronized = true;
};

TEST_F(RetentionByAgeTest, AnOldRunIsDeleted) {
  turn_until(
      0.0, [this] { return deleted(); }, 401.0);
}

// More turns than jobs may wait: the deletion found no room behind readings of the directory, and was lost.
TEST_F(RetentionByAgeTest, AnOldRunIsDeletedHoweverManyTurnsComeBeforeTheDirectoryIsRead) {
  for (std::size_t i = 0; i < 4 * JobThread::kJobs; ++i) turn(0.0, 401.0);
  turn_until(
      0.0, [this] { return deleted(); }, 401.0);
}

// A signature moves the head of a file. The ledger compared the new head with the one at the run's end, and refused the
// deletion for ever.
TEST_F(RetentionByAgeTest, ARunThatWasSignedIsDeletedLikeAnother) {
  PersonalSignature words;
  words.name = "Anna";
  words.meaning = "reviewed";
  words.utc = iso_utc(kMidnight_utc_ns);
  words.person = Person{1000, "anna"};
  const auto key = SigningKey::load(key_path(scratch.path()));
  ASSERT_TRUE(key) << key.error();
  std::string file;
  look_at_runs(
      scratch.path(), "", [&](const ListedRun& run) { file = run.file; }, [] { return false; });
  const auto signature = sign_by_service(scratch.path(file), words, *key);
  ASSERT_TRUE(signature) << signature.error();
  ASSERT_TRUE(folder.run_signed(1, *signature).get());
  turn_until(
      0.0, [this] { return deleted(); }, 401.0);
}

// The service ended between the ledger's entry and the removal of the file.
TEST_F(RetentionByAgeTest, ARunThatTheLedgerHasAsDeletedLosesItsFileAtTheNextLook) {
  ASSERT_TRUE(folder.run_deleted(1, "older than 400 days").get());
  turn_until(
      0.0, [this] { return deleted(); }, 401.0);
  EXPECT_FALSE(notices.hold("could not be told")) << notices.text();
}

TEST_F(RetentionByAgeTest, NothingIsDeletedWhileTheClockIsNotSynchronized) {
  synchronized = false;
  turn_until(
      0.0, [this] { return deleted() || notices.hold("too old"); }, 401.0);
  EXPECT_FALSE(deleted());
  EXPECT_TRUE(
      notices.hold("runs that seem too old to be kept: 1; nothing is deleted by age: the computer's clock is not "
                   "synchronized"))
      << notices.text();
}

TEST_F(RetentionByAgeTest, NothingIsDeletedForADayAfterTheClockWasSet) {
  constexpr double kSet_s = 700.0, kDay_s = 86'400.0;
  turn(0.0);
  turn_until(
      kSet_s, [this] { return deleted() || notices.hold("too old"); }, 401.0);
  EXPECT_TRUE(notices.hold("the computer's clock was set within the last day")) << notices.text();
  for (double t_s = kSet_s; t_s < kSet_s + kDay_s; t_s += 600.0) turn(t_s, 401.0);
  EXPECT_FALSE(deleted());
  turn_until(
      kSet_s + kDay_s + 600.0, [this] { return deleted(); }, 401.0);  // who set it had a day to see the line
}

}  // namespace
}  // namespace dwell::record
