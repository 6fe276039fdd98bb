// How often recording waits for the disk. A wait may take half a second, and what comes meanwhile is only in memory.
#include <gtest/gtest.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>

#include "daemon/record/run_folder.hpp"
#include "tests/record/recorded_rig.hpp"
#include "tests/record/scratch.hpp"

namespace {
std::atomic<int> waits{0};
}  // namespace

// In place of the C library's, for SQLite as well: so they must be visible to it.
extern "C" __attribute__((visibility("default"))) int fsync(int file) {
  ++waits;
  return static_cast<int>(syscall(SYS_fsync, file));
}
extern "C" __attribute__((visibility("default"))) int fdatasync(int file) {
  ++waits;
  return static_cast<int>(syscall(SYS_fdatasync, file));
}

namespace dwell::record {
namespace {

TEST(DiskWaits, AreOneForABatchAndFiveForTheBeginningAndForTheEndOfARun) {
  const Scratch scratch;
  RunFolder folder(folder_options(scratch.path()));
  ASSERT_TRUE(folder.open());
  const std::vector<NewEntry> batch{{"event", 1, R"({"position":1,"what":"state","text":"idle"})"}};
  const auto count = [](const auto& step) {
    const int before = waits;
    EXPECT_TRUE(step()) << "failed";
    return waits - before;
  };
  RunHeader header = rig_header();
  header.start_utc = "2026-11-23T00:00:00Z";
  for (int run = 1; run <= 2; ++run) {
    EXPECT_EQ(count([&] { return folder.begin(header, 1, batch).has_value(); }), 5) << "run " << run;
    EXPECT_EQ(count([&] { return folder.write(batch).has_value(); }), 1) << "run " << run;
    EXPECT_EQ(count([&] { return folder.end(batch).has_value(); }), 5) << "run " << run;
  }
}

}  // namespace
}  // namespace dwell::record
