// A run file beside its living writer, and after the writer was killed at any instant.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "daemon/record/audit.hpp"
#include "daemon/record/block.hpp"
#include "tests/record/altered_files.hpp"

namespace dwell::record {
namespace {

constexpr std::size_t kPerBlock = 3000;

// Never returns. Tells the number of blocks after each commit through `told`; closes the file after `blocks`.
[[noreturn]] void write_and_tell(const std::string& path, int blocks, int told) {
  const RunHeader header = sample_header(1, sample_key());
  Result<ChainWriter> file = ChainWriter::create(path, ChainSort::run, "dwell/run/" + header.id, sample_key());
  std::mt19937 random(1);
  std::vector<Record> records(kPerBlock);
  for (Record& record : records) record.value = static_cast<double>(random());
  const std::string block = encode_block(records);
  bool good = file && file->append("run", 0, to_json(header));
  for (int i = 1; good && i <= blocks; ++i) {
    good = file->append("stream", i, block) && file->commit() && ::write(told, &i, sizeof i) == sizeof i;
  }
  RunEnd end;
  end.why = "operator";
  good = good && file->append("end", blocks, to_json(end)) && file->close();
  ::_exit(good ? 0 : 1);
}

// The last number in the pipe that nobody writes to any more; 0: none.
int last_told(int pipe) {
  int last = 0, number = 0;
  while (::read(pipe, &number, sizeof number) == static_cast<ssize_t>(sizeof number)) last = number;
  return last;
}

TEST(LiveAudit, BesideAWriterEachAuditSeesAnOpenRunAndTheLastOneAnIntactOne) {
  const Scratch scratch(true);
  const std::string path = scratch.path("a.dwell");
  int pipe[2];
  ASSERT_EQ(::pipe(pipe), 0);
  (void)sample_key();
  const pid_t writer = ::fork();
  if (writer == 0) write_and_tell(path, 700, pipe[1]);  // 16 MB twice: a checkpoint is due on the way
  ::close(pipe[1]);
  int status = 0;
  std::uint64_t samples = 0;
  while (::waitpid(writer, &status, WNOHANG) == 0) {
    if (::access(path.c_str(), F_OK) != 0) continue;
    const Result<Audit> audit = audit_run(path, {});
    ASSERT_TRUE(audit) << audit.error();
    ASSERT_NE(audit->state, AuditState::tampered) << audit->where;
    EXPECT_GE(audit->samples, samples) << "what was seen once is seen again";
    samples = audit->samples;
  }
  ::close(pipe[0]);
  EXPECT_EQ(status, 0);
  const Result<Audit> audit = audit_run(path, {});
  EXPECT_EQ(audit->state, AuditState::intact) << audit->where;
  EXPECT_EQ(audit->samples, 700 * kPerBlock);
}

TEST(LiveAudit, AWriterKilledAtAnyInstantLeavesAllThatItCommitted) {
  std::mt19937 random(7);
  for (int kill = 0; kill < 40; ++kill) {
    const Scratch scratch(true);
    const std::string path = scratch.path("a.dwell");
    int pipe[2];
    ASSERT_EQ(::pipe(pipe), 0);
    const pid_t writer = ::fork();
    if (writer == 0) write_and_tell(path, 100'000, pipe[1]);
    ::close(pipe[1]);
    // The instant of the kill is drawn in blocks, and in the time that one takes.
    int told = 0;
    for (int wait = static_cast<int>(random() % 60); wait > 0; --wait)
      if (::read(pipe[0], &told, sizeof told) <= 0) break;
    for (auto spin = random() % 300'000; spin > 0; --spin) asm volatile("");
    ::kill(writer, SIGKILL);
    int status = 0;
    ::waitpid(writer, &status, 0);
    told = std::max(told, last_told(pipe[0]));
    ::close(pipe[0]);
    if (::access(path.c_str(), F_OK) != 0) {
      EXPECT_EQ(told, 0);
      continue;
    }
    const Files before = files_in(scratch);
    const Result<Audit> audit = audit_run(path, {});
    ASSERT_TRUE(audit) << audit.error();
    EXPECT_EQ(audit->state, AuditState::open) << audit->where;
    EXPECT_GE(audit->samples, static_cast<std::uint64_t>(told) * kPerBlock);
    EXPECT_EQ(files_in(scratch), before);
  }
}

}  // namespace
}  // namespace dwell::record
