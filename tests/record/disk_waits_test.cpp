// How long recording waits for the disk, and what a loss of power costs meanwhile. A disk in virtual time: each wait
// takes 0.5 s of it, and threads wait for the disk side by side.
#include <gtest/gtest.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <map>
#include <mutex>
#include <random>
#include <string>
#include <string_view>

#include "daemon/record/audit.hpp"
#include "daemon/record/file_name.hpp"
#include "daemon/record/run_folder.hpp"
#include "tests/record/recorded_rig.hpp"
#include "tests/record/scratch.hpp"
#include "tests/record/synthetic_stream.hpp"

namespace {
thread_local int own_waits = 0;  // of this thread
std::atomic<int> all_waits{0};   // of all threads

// While it is closed, no wait for the ledger's file ends; after 10 s of that somebody is taken to wait for it.
class LedgersDisk {
 public:
  void close() { set(true); }
  void open() { set(false); }
  void pass(int file) {
    char path[4096];
    const ssize_t length = readlink(("/proc/self/fd/" + std::to_string(file)).c_str(), path, sizeof path);
    if (length <= 0 ||
        std::string_view(path, static_cast<std::size_t>(length)).find("ledger") == std::string_view::npos)
      return;
    std::unique_lock lock(mutex_);
    ++came_;
    held_ = held_ || !opened_.wait_for(lock, std::chrono::seconds(10), [this] { return !closed_; });
  }
  // How many waits there were since close(), and whether one had to be let through.
  [[nodiscard]] int came() const {
    const std::lock_guard lock(mutex_);
    return came_;
  }
  [[nodiscard]] bool held() const {
    const std::lock_guard lock(mutex_);
    return held_;
  }

 private:
  void set(bool closed) {
    {
      const std::lock_guard lock(mutex_);
      closed_ = closed;
      if (closed) came_ = 0;
    }
    opened_.notify_all();
  }

  mutable std::mutex mutex_;
  std::condition_variable opened_;
  bool closed_ = false, held_ = false;
  int came_ = 0;
};
LedgersDisk ledgers_disk;
}  // namespace

// In place of the C library's, for SQLite as well: so they must be visible to it.
extern "C" __attribute__((visibility("default"))) int fsync(int file) {
  ++own_waits, ++all_waits;
  ledgers_disk.pass(file);
  return static_cast<int>(syscall(SYS_fsync, file));
}
extern "C" __attribute__((visibility("default"))) int fdatasync(int file) {
  ++own_waits, ++all_waits;
  ledgers_disk.pass(file);
  return static_cast<int>(syscall(SYS_fdatasync, file));
}

namespace dwell::record {
namespace {

constexpr double kWait_s = 0.5;

RunHeader header_of_run() {
  RunHeader header = rig_header();
  header.start_utc = "2026-11-23T00:00:00Z";
  return header;
}

// A folder that notes for how long the recorder's thread has waited, and how old the oldest datum was that a loss of
// power would have cost.
class WatchedFolder final : public RunStore {
 public:
  explicit WatchedFolder(const std::string& directory) : directory_(directory), folder_(folder_options(directory)) {}

  // The record handed to the log next is of this instant. It cannot be taken while the thread waits.
  void now(double t_s) noexcept { now_s_ = std::max(now_s_, t_s); }
  // At a run's beginning nothing before its instant can be lost.
  void begins(double t_s) noexcept { durable_s_ = std::max(durable_s_, t_s); }
  [[nodiscard]] double now_s() const noexcept { return now_s_; }
  [[nodiscard]] double most_lost_s() const noexcept { return most_lost_s_; }
  [[nodiscard]] int most_waits() const noexcept { return most_waits_; }
  // How many batches took so many waits.
  [[nodiscard]] int writes_with(int waits) const { return waits_.contains(waits) ? waits_.at(waits) : 0; }
  // Bytes of the longest -wal of a run.
  [[nodiscard]] std::uintmax_t longest_log() const noexcept { return longest_log_; }

  Result<void> ready() override {
    if (!folder_.is_open()) return folder_.ready();  // measuring has not begun
    const int before = own_waits;
    const Result<void> done = folder_.ready();
    now_s_ += kWait_s * (own_waits - before);
    return done;
  }
  Result<void> begin(RunHeader& header, std::int64_t t_ns, std::span<const NewEntry> first) override {
    return watch(first, [&] { return folder_.begin(header, t_ns, first); });
  }
  Result<void> write(std::span<const NewEntry> batch) override {
    return watch(batch, [&] { return folder_.write(batch); });
  }
  Result<void> end(std::span<const NewEntry> last) override {
    return watch(last, [&] { return folder_.end(last); });
  }

 private:
  template <class Call>
  Result<void> watch(std::span<const NewEntry> batch, const Call& call) {
    const int before = own_waits;
    const Result<void> done = call();
    std::error_code none;
    const auto bytes = std::filesystem::file_size(directory_ + "/" + folder_.file() + "-wal", none);
    if (!none) longest_log_ = std::max(longest_log_, bytes);
    most_waits_ = std::max(most_waits_, own_waits - before);
    ++waits_[own_waits - before];
    now_s_ += kWait_s * (own_waits - before);
    most_lost_s_ = std::max(most_lost_s_, now_s_ - durable_s_);
    for (const NewEntry& entry : batch) durable_s_ = std::max(durable_s_, 1e-9 * static_cast<double>(entry.t_ns));
    return done;
  }

  const std::string directory_;
  RunFolder folder_;
  std::uintmax_t longest_log_ = 0;
  double now_s_ = 0.0, durable_s_ = 0.0, most_lost_s_ = 0.0;
  int most_waits_ = 0;
  std::map<int, int> waits_;
};

struct SlowDiskRig {
  SlowDiskRig()
      : log(store, log_options(notices)), stream(2, 1000.0, [this](const Record& record) {
          const double t_s = 1e-9 * static_cast<double>(record.t_ns);
          store.now(t_s);
          if (record.kind == Kind::run && static_cast<RunEdge>(record.flags) == RunEdge::begins) store.begins(t_s);
          log.set_clock({record.t_ns, 1'790'000'000'000'000'000 + record.t_ns});
          log.record(record);
          if (store.now_s() <= t_s) log.caught_up();
        }) {
    EXPECT_TRUE(store.ready());
  }

  Scratch scratch;
  Notices notices;
  WatchedFolder store{scratch.path()};
  RunLog log;
  SyntheticStream stream;
};

// A sample's interval, with room for rounding: the newest datum that is kept is so much older than the first that is
// lost.
constexpr double kSample_s = 0.001 + 1e-9;

TEST(DiskWaits, OfTheRecordersThreadAreOneForABatchAndOneForTheBeginningOrTheEndOfARunAndNoneForTheLedger) {
  const Scratch scratch;
  RunFolder folder(folder_options(scratch.path()));
  ASSERT_TRUE(folder.ready());
  const std::vector<NewEntry> batch{{"event", 1, R"({"position":1,"what":"state","text":"idle"})"}};
  const auto count = [](const auto& step) {
    const int before = own_waits;
    EXPECT_TRUE(step()) << "failed";
    return own_waits - before;
  };
  RunHeader header = header_of_run();
  for (int run = 1; run <= 3; ++run) {
    EXPECT_EQ(count([&] { return folder.begin(header, 1, batch).has_value(); }), 1) << "run " << run;
    EXPECT_EQ(count([&] { return folder.write(batch).has_value(); }), 1) << "run " << run;
    EXPECT_EQ(count([&] { return folder.end(batch).has_value(); }), 1) << "run " << run;
    if (run == 2) continue;  // another run may follow at once
    folder.settle();
    EXPECT_EQ(count([&] { return folder.ready().has_value(); }), 0) << "run " << run;
  }
}

// At the beginning two for the ledger's entry and the name of the file, and four for the file of a later run. At the
// end five: the ledger's entry, and the logs that go into the files.
TEST(DiskWaits, OfOtherThreadsAreSixForTheBeginningAndFiveForTheEnd) {
  const Scratch scratch;
  RunFolder folder(folder_options(scratch.path()));
  ASSERT_TRUE(folder.ready());
  folder.settle();
  const std::vector<NewEntry> batch{{"event", 1, R"({"position":1,"what":"state","text":"idle"})"}};
  const auto beside = [&](const auto& step) {
    const int own = own_waits, all = all_waits;
    EXPECT_TRUE(step()) << "failed";
    folder.settle();
    return (all_waits - all) - (own_waits - own);
  };
  RunHeader header = header_of_run();
  for (int run = 1; run <= 2; ++run) {
    EXPECT_EQ(beside([&] { return folder.begin(header, 1, batch).has_value(); }), 6) << "run " << run;
    EXPECT_EQ(beside([&] { return folder.write(batch).has_value(); }), 0) << "run " << run;
    EXPECT_EQ(beside([&] { return folder.end(batch).has_value(); }), 5) << "run " << run;
  }
}

// Its entries came before the run could begin, and its log moved into its file meanwhile.
TEST(SlowDisk, NoRunWaitsForTheLedger) {
  const Scratch scratch;
  RunFolder folder(folder_options(scratch.path()));
  ASSERT_TRUE(folder.ready());
  folder.settle();
  StoredEvent event;
  event.position = 1;
  event.utc = "2026-11-23T00:00:00Z";
  event.what = "state";
  event.text = "idle";
  const std::vector<NewEntry> batch{{"event", 1, to_json(event)}};
  const std::vector<NewEntry> end{{"end", 1, to_json(RunEnd{"operator", 0, 0, "2026-11-23T00:00:01Z"})}};
  ledgers_disk.close();
  for (int run = 1; run <= 3; ++run) {
    RunHeader header = header_of_run();
    ASSERT_TRUE(folder.begin(header, 1, batch)) << "run " << run;
    EXPECT_EQ(header.run, run);
    EXPECT_TRUE(folder.write(batch)) << "run " << run;
    EXPECT_TRUE(folder.end(end)) << "run " << run;
    EXPECT_TRUE(folder.ready()) << "run " << run;
    EXPECT_TRUE(folder.take_ended().empty()) << "listed before the ledger knows run " << run;
  }
  EXPECT_FALSE(ledgers_disk.held());
  ledgers_disk.open();
  folder.settle();
  EXPECT_GE(ledgers_disk.came(), 9) << "the ledger's disk was not asked: a beginning, an end and a log of three runs";
  const auto ended = folder.take_ended();
  ASSERT_EQ(ended.size(), 3U);
  AuditOptions with_ledger;
  with_ledger.ledger = ledger_in(scratch.path());
  for (const EndedRunFile& run : ended) {
    const auto audit = audit_run(scratch.path(run.file), with_ledger);
    ASSERT_TRUE(audit) << audit.error();
    EXPECT_EQ(audit->state, AuditState::intact) << run.file << ": " << audit->where;
  }
}

TEST(SlowDisk, ALossOfPowerCostsOneAndAHalfSecondsAtMostFromTheBeginningOfARunOn) {
  SlowDiskRig rig;
  rig.stream.starts();
  rig.stream.play(20.0);
  rig.log.finish();
  EXPECT_GT(rig.store.most_lost_s(), 1.0) << "nothing was watched";
  EXPECT_LE(rig.store.most_lost_s(), 1.5 + kSample_s) << rig.notices.text();
}

TEST(SlowDisk, ALossOfPowerCostsTwoSecondsAtMostWhereOneRunFollowsAnother) {
  SlowDiskRig rig;
  rig.stream.starts();
  // Amid a block, while a block is being written, and just after one is complete.
  for (const double length_s : {3.7, 4.2, 5.01}) {
    rig.stream.play(length_s);
    rig.stream.ends(EndOfRun::by_operator);
    rig.stream.starts();
  }
  rig.stream.play(3.7);
  rig.log.finish();
  EXPECT_TRUE(rig.notices.hold("run 4")) << rig.notices.text();
  EXPECT_LE(rig.store.most_lost_s(), 2.0 + kSample_s) << rig.notices.text();
}

// The recorder looks whether runs can be recorded just before the record that begins the next run.
TEST(SlowDisk, ALossOfPowerCostsTwoSecondsAtMostWhereARunBeginsAsTheLedgerHearsOfTheEndOfAnother) {
  for (const double pause_s : {0.0, 0.02, 0.1, 0.2, 0.3, 0.6, 1.1, 2.0}) {
    SlowDiskRig rig;
    rig.stream.starts();
    rig.stream.play(4.2);
    rig.stream.ends(EndOfRun::by_operator);
    rig.stream.play(pause_s);
    ASSERT_TRUE(rig.store.ready());
    rig.stream.starts();
    rig.stream.play(3.7);
    rig.log.finish();
    EXPECT_LE(rig.store.most_lost_s(), 2.0 + kSample_s) << pause_s << " s of pause\n" << rig.notices.text();
  }
}

// The last batch of a run makes its log so long that it would be moved, or it has just been moved, and the next run
// follows at once.
TEST(SlowDisk, ALossOfPowerCostsTwoSecondsAtMostWhereARunEndsAsItsLogIsDueToMoveOrHasJustMoved) {
  int moved = 0;
  StoredEvent large;
  large.what = "state";
  large.text = std::string(1'500'000, 'x');
  for (int seconds = 8; seconds <= 12; ++seconds) {
    SlowDiskRig rig;
    rig.stream.starts();
    for (int second = 0; second < seconds; ++second) {
      rig.log.event(large);
      rig.stream.play(1.0);
    }
    rig.log.event(large);
    rig.stream.play(0.2);
    rig.stream.ends(EndOfRun::by_operator);
    rig.stream.starts();
    rig.stream.play(3.7);
    rig.log.finish();
    moved += rig.store.writes_with(2);
    EXPECT_LE(rig.store.most_lost_s(), 2.0 + kSample_s) << seconds << " s\n" << rig.notices.text();
  }
  EXPECT_EQ(moved, 2) << "at 11 and at 12 seconds";
}

// Runs of a second and more, with pauses or without. The log of every third one has moved shortly before the run ends,
// or is due to.
TEST(SlowDisk, ALossOfPowerCostsTwoSecondsAtMostHoweverRunsOfASecondOrMoreFollowEachOther) {
  StoredEvent large;
  large.what = "state";
  large.text = std::string(1'500'000, 'x');
  int moved = 0;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    SlowDiskRig rig;
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> length_s(1.0, 3.0), pause_s(-1.0, 1.0);
    for (int run = 0; run < 9; ++run) {
      rig.stream.starts();
      for (int second = 0; run % 3 == 2 && second < 10; ++second) {
        rig.log.event(large);
        rig.stream.play(1.0);
      }
      rig.log.event(large);
      rig.stream.play(length_s(random));
      rig.stream.ends(EndOfRun::by_operator);
      rig.stream.play(std::max(pause_s(random), 0.0));
    }
    rig.log.finish();
    moved += rig.store.writes_with(2);
    EXPECT_LE(rig.store.most_lost_s(), 2.0 + kSample_s) << "seed " << seed << "\n" << rig.notices.text();
  }
  EXPECT_GE(moved, 20) << "hardly a log moved";
}

// Every 16 MB.
TEST(SlowDisk, ALossOfPowerCostsTwoSecondsAtMostWhereTheLogMovesIntoTheDatabase) {
  SlowDiskRig rig;
  rig.stream.starts();
  StoredEvent large;
  large.what = "state";
  large.text = std::string(1'500'000, 'x');
  for (int second = 0; second < 30; ++second) {
    rig.log.event(large);
    rig.stream.play(1.0);
  }
  EXPECT_EQ(rig.store.most_waits(), 2) << "it was moved";
  EXPECT_EQ(rig.store.writes_with(2), 2) << "a new log begins with one wait";
  EXPECT_LT(rig.store.longest_log(), 2 * 16'000'000U) << "it was never moved";
  rig.log.finish();
  EXPECT_LE(rig.store.most_lost_s(), 2.0 + kSample_s) << rig.notices.text();
}

}  // namespace
}  // namespace dwell::record
