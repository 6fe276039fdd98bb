#include "daemon/record/chain_file.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "daemon/record/run_entries.hpp"
#include "tests/record/locked_for_others.hpp"
#include "tests/record/scratch.hpp"

namespace dwell::record {
namespace {

constexpr const char* kOrigin = "dwell/run/0123456789abcdef0123456789abcdef";

const SigningKey& service_key() {
  static const SigningKey kKey = *SigningKey::make("rig-7");
  return kKey;
}

Result<std::vector<ChainReader::Row>> read_all(const std::string& path, ChainSort sort = ChainSort::run) {
  Result<ChainReader> reader = ChainReader::open(path, sort);
  if (!reader) return tl::unexpected(reader.error());
  std::vector<ChainReader::Row> rows;
  for (;;) {
    Result<std::optional<ChainReader::Row>> row = reader->next();
    if (!row) return tl::unexpected(row.error());
    if (!*row) return rows;
    rows.push_back(std::move(**row));
  }
}

std::string noise(std::size_t size, unsigned seed) {
  std::mt19937 random(seed);
  std::string out(size, '\0');
  for (char& byte : out) byte = static_cast<char>(random());
  return out;
}

// Every file of a directory with its bytes.
std::map<std::string, std::string> contents(const std::string& directory) {
  std::map<std::string, std::string> files;
  for (const auto& file : std::filesystem::directory_iterator(directory))
    files[file.path().filename().string()] = Scratch::read(file.path().string());
  return files;
}

// Else whoever removes the file of a run that is recorded loses the run without a word.
TEST(ChainFile, ACommitFailsOnceTheFileWasRemoved) {
  const Scratch scratch;
  const std::string path = scratch.path("a.dwell");
  Result<ChainWriter> writer = ChainWriter::create(path, ChainSort::run, kOrigin, service_key());
  ASSERT_TRUE(writer) << writer.error();
  ASSERT_TRUE(writer->append("run", 5, "{}"));
  ASSERT_TRUE(writer->commit());
  std::filesystem::remove(path);
  ASSERT_TRUE(writer->append("note", 6, "{}"));
  const Result<void> committed = writer->commit();
  ASSERT_FALSE(committed);
  EXPECT_EQ(committed.error(), path + ": the file was removed while it was written");
}

TEST(ChainFile, WhatWasCommittedIsReadBackWithHeadsAndNotes) {
  const Scratch scratch;
  const std::string path = scratch.path("a.dwell");
  Result<ChainWriter> writer = ChainWriter::create(path, ChainSort::run, kOrigin, service_key());
  ASSERT_TRUE(writer) << writer.error();
  const std::string large = noise(3 << 20, 1);
  ASSERT_TRUE(writer->append("run", 5, "{}"));
  ASSERT_TRUE(writer->append("stream", 6, large));
  EXPECT_EQ(writer->committed(), 0);
  ASSERT_TRUE(writer->commit());
  EXPECT_EQ(writer->committed(), 2);
  ASSERT_TRUE(writer->append("end", 7, "{}"));
  ASSERT_TRUE(writer->close());

  const auto rows = read_all(path);
  ASSERT_TRUE(rows) << rows.error();
  ASSERT_EQ(rows->size(), 3u);
  Digest head{};
  for (const ChainReader::Row& row : *rows) {
    head = next_head(head, row.entry);
    EXPECT_EQ(row.head, head);
  }
  EXPECT_EQ((*rows)[1].entry.body, large);
  EXPECT_EQ((*rows)[0].note, "") << "the note is on the last entry of a commit";
  const auto text_of = [](const Digest& digest) {
    return base64({reinterpret_cast<const char*>(digest.data()), digest.size()});
  };
  const std::string text =
      std::string(kOrigin) + "\n3\n" + text_of(head) + "\n7\n2\n" + text_of(note_hash((*rows)[1].note)) + "\n";
  EXPECT_EQ(service_key().public_key().open((*rows)[2].note).value_or("?"), text);
  EXPECT_EQ(writer->committed_head(), head);
  EXPECT_EQ(contents(scratch.path()).size(), 1u) << "a closed file is one file";
}

TEST(ChainFile, WhatIsNotCommittedIsNotRead) {
  const Scratch scratch;
  const std::string path = scratch.path("a.dwell");
  ChainWriter writer = *ChainWriter::create(path, ChainSort::run, kOrigin, service_key());
  EXPECT_EQ(read_all(path)->size(), 0u);
  ASSERT_TRUE(writer.append("run", 1, "a"));
  EXPECT_EQ(read_all(path)->size(), 0u);
  ASSERT_TRUE(writer.commit());
  ASSERT_TRUE(writer.append("event", 2, "taken back"));
  writer.roll_back();
  ASSERT_TRUE(writer.append("event", 3, "kept"));
  ASSERT_TRUE(writer.commit());
  const auto rows = read_all(path);
  ASSERT_EQ(rows->size(), 2u);
  EXPECT_EQ(rows->back().entry.body, "kept");
  EXPECT_EQ(rows->back().head, writer.committed_head());
}

TEST(ChainFile, WhatNoReaderWouldTakeIsNotWritten) {
  const Scratch scratch(true);
  const std::string path = scratch.path("a.dwell");
  ChainWriter writer = *ChainWriter::create(path, ChainSort::run, kOrigin, service_key());
  ASSERT_TRUE(writer.append("run", 1, "{}"));
  ASSERT_TRUE(writer.commit());
  for (const char* kind : {"run", "result", "event", "signature"}) {
    const Result<void> refused = writer.append(kind, 2, std::string(kMaxJson + 1, ' '));
    ASSERT_FALSE(refused) << kind;
    EXPECT_NE(refused.error().find(path + ": a " + kind + " entry of 8388609 bytes; at most 8388608 can be read back"),
              std::string::npos)
        << refused.error();
  }
  ASSERT_TRUE(writer.append("stream", 2, std::string(kMaxJson + 1, ' '))) << "blocks may be larger";
  ASSERT_TRUE(writer.close());
  EXPECT_EQ(read_all(path)->size(), 2u);
}

TEST(ChainFile, ReadingAltersNoByteWhileItIsWrittenAndAfterACrash) {
  const Scratch scratch;
  const std::string path = scratch.path("a.dwell");
  ChainWriter writer = *ChainWriter::create(path, ChainSort::run, kOrigin, service_key());
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(writer.append("stream", i, noise(30000, static_cast<unsigned>(i))));
    ASSERT_TRUE(writer.commit());
  }
  const auto before = contents(scratch.path());
  EXPECT_EQ(before.size(), 2u) << "the file and its -wal, no -shm";
  EXPECT_EQ(read_all(path)->size(), 20u);
  EXPECT_EQ(contents(scratch.path()), before);

  // What a crash leaves: the files as they lie on the disk.
  const Scratch after;
  for (const auto& [name, bytes] : before) after.write(name, bytes);
  EXPECT_EQ(read_all(after.path("a.dwell"))->size(), 20u);
  EXPECT_EQ(contents(after.path()), before);
}

TEST(ChainFile, AReadOnlyDirectoryIsEnoughForReading) {
  const Scratch scratch;
  const std::string path = scratch.path("a.dwell");
  ChainWriter writer = *ChainWriter::create(path, ChainSort::run, kOrigin, service_key());
  ASSERT_TRUE(writer.append("run", 1, "a"));
  ASSERT_TRUE(writer.commit());
  ::chmod(scratch.path().c_str(), 0555);
  const pid_t child = ::fork();
  if (child == 0) {
    // root may write everywhere; nobody may not.
    const bool plain = ::geteuid() != 0 || ::setuid(65534) == 0;
    const auto rows = read_all(path);
    ::_exit(plain && rows && rows->size() == 1 ? 0 : 1);
  }
  int status = -1;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ::chmod(scratch.path().c_str(), 0755);
  EXPECT_EQ(status, 0);
}

TEST(ChainFile, AReaderSeesOneStateWhileTheWriterGoesOn) {
  const Scratch scratch;
  const std::string path = scratch.path("a.dwell");
  ChainWriter writer = *ChainWriter::create(path, ChainSort::run, kOrigin, service_key());
  const auto write = [&writer](int count) {
    for (int i = 0; i < count; ++i) {
      ASSERT_TRUE(writer.append("stream", i, noise(1 << 20, 7)));
      ASSERT_TRUE(writer.commit());
    }
  };
  write(10);
  Result<ChainReader> reader = ChainReader::open(path, ChainSort::run);
  ASSERT_TRUE(reader) << reader.error();
  ASSERT_TRUE(reader->next());
  write(30);  // a checkpoint would be due
  int rows = 1;
  for (;;) {
    const auto row = reader->next();
    ASSERT_TRUE(row) << row.error();
    if (!*row) break;
    ++rows;
  }
  EXPECT_EQ(rows, 10);
  EXPECT_GT(std::filesystem::file_size(path + "-wal"), 30u << 20);
  reader = ChainReader::open(scratch.path("nothing"), ChainSort::run);
  write(1);
  EXPECT_LT(std::filesystem::file_size(path + "-wal"), 1u << 20) << "nobody reads: the log goes into the database";
  EXPECT_EQ(read_all(path)->size(), 41u);
}

TEST(ChainFile, AFileClosedWhileItIsReadSaysSo) {
  const Scratch scratch;
  const std::string path = scratch.path("a.dwell");
  ChainWriter writer = *ChainWriter::create(path, ChainSort::run, kOrigin, service_key());
  for (int i = 0; i < 5; ++i) {
    ASSERT_TRUE(writer.append("stream", i, noise(100000, 7)));
    ASSERT_TRUE(writer.commit());
  }
  Result<ChainReader> reader = ChainReader::open(path, ChainSort::run);
  ASSERT_TRUE(reader->next());
  ASSERT_TRUE(writer.close());
  const auto row = reader->next();
  ASSERT_FALSE(row);
  EXPECT_NE(row.error().find("read it again"), std::string::npos) << row.error();
  EXPECT_EQ(read_all(path)->size(), 5u);
}

TEST(ChainFile, NobodyElseWritesWhileAWriterLives) {
  const Scratch scratch;
  const std::string path = scratch.path("a.dwell");
  ChainWriter writer = *ChainWriter::create(path, ChainSort::run, kOrigin, service_key());
  ASSERT_TRUE(writer.append("run", 1, "a"));
  ASSERT_TRUE(writer.commit());
  EXPECT_EQ(read_all(path)->size(), 1u);  // a reader in this process takes nothing from the writer
  const pid_t child = ::fork();
  if (child == 0) ::_exit(ChainWriter::open(path, ChainSort::run, kOrigin, service_key()) ? 1 : 0);
  int status = -1;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
}

TEST(ChainFile, NoOtherProcessWritesEitherOnceTheLogHasMovedIntoTheFile) {
  const Scratch scratch;
  const std::string path = scratch.path("a.dwell");
  Result<ChainWriter> writer = ChainWriter::create(path, ChainSort::run, kOrigin, service_key());
  ASSERT_TRUE(writer) << writer.error();
  for (int k = 0; k < 2; ++k) {
    ASSERT_TRUE(writer->append("note", k, "one")) << k;
    ASSERT_TRUE(writer->commit()) << k;
    EXPECT_TRUE(locked_for_others(path)) << k;
    const Result<void> merged = writer->merge_log();
    ASSERT_TRUE(merged) << merged.error();
    EXPECT_TRUE(locked_for_others(path)) << "after merge " << k;
  }
  ASSERT_TRUE(writer->close());
  EXPECT_FALSE(locked_for_others(path));
}

TEST(ChainFile, AClosedFileCanBeAppendedTo) {
  const Scratch scratch;
  const std::string path = scratch.path("a.dwell");
  ChainWriter first = *ChainWriter::create(path, ChainSort::run, kOrigin, service_key());
  ASSERT_TRUE(first.append("end", 1, "a"));
  ASSERT_TRUE(first.close());
  EXPECT_FALSE(first.append("late", 1, "")) << "a closed writer takes nothing";

  Result<ChainWriter> without =
      ChainWriter::open_without_key(path, ChainSort::run, kOrigin, service_key().public_key());
  ASSERT_TRUE(without) << without.error();
  ASSERT_TRUE(without->append("signature", 2, "b"));
  ASSERT_TRUE(without->close());
  Result<ChainWriter> second = ChainWriter::open(path, ChainSort::run, kOrigin, service_key());
  ASSERT_TRUE(second) << second.error();
  ASSERT_TRUE(second->append("signature", 3, "c"));
  ASSERT_TRUE(second->close());

  const auto rows = read_all(path);
  ASSERT_EQ(rows->size(), 3u);
  EXPECT_EQ((*rows)[1].note, "");
  EXPECT_NE((*rows)[2].note, "");
  EXPECT_EQ((*rows)[2].head, second->committed_head());
  EXPECT_EQ(contents(scratch.path()).size(), 1u);
}

// A crash between the making of a ledger and its first entry leaves such a file.
TEST(ChainFile, OneWithoutAnEntryIsAppendedTo) {
  const Scratch scratch;
  const std::string path = scratch.path("a.dwell");
  { ASSERT_TRUE(ChainWriter::create(path, ChainSort::run, kOrigin, service_key())); }
  Result<ChainWriter> writer = ChainWriter::open(path, ChainSort::run, kOrigin, service_key());
  ASSERT_TRUE(writer) << writer.error();
  ASSERT_TRUE(writer->append("event", 1, "{}"));
  EXPECT_TRUE(writer->commit());
  EXPECT_EQ(writer->committed(), 1);
}

TEST(ChainFile, WhatIsNotOnesOwnIsNotAppendedTo) {
  const Scratch scratch;
  const std::string path = scratch.path("a.dwell");
  ChainWriter writer = *ChainWriter::create(path, ChainSort::run, kOrigin, service_key());
  ASSERT_TRUE(writer.append("run", 1, "a"));
  ASSERT_TRUE(writer.close());
  const std::string before = Scratch::read(path);
  EXPECT_FALSE(ChainWriter::open(path, ChainSort::run, kOrigin, *SigningKey::make("rig-7")));
  EXPECT_FALSE(ChainWriter::open(path, ChainSort::run, "dwell/run/other", service_key()));
  EXPECT_FALSE(ChainWriter::open(path, ChainSort::ledger, kOrigin, service_key()));
  EXPECT_FALSE(ChainWriter::create(path, ChainSort::run, kOrigin, service_key()));
  EXPECT_EQ(Scratch::read(path), before);
}

TEST(ChainFile, WhatIsNoRunFileIsRefusedWithTheReason) {
  const Scratch scratch;
  EXPECT_FALSE(read_all(scratch.path("nothing")));
  const std::string text = scratch.write("text", "time,x\n0,1\n");
  const auto rows = read_all(text);
  ASSERT_FALSE(rows);
  EXPECT_NE(rows.error().find("not a database"), std::string::npos) << rows.error();
  EXPECT_FALSE(read_all(scratch.write("empty", "")));
  EXPECT_FALSE(read_all(scratch.path()));
}

TEST(ChainFile, ADiskThatIsFullLosesNothingThatWasCommitted) {
  const Scratch scratch;
  const std::string path = scratch.path("a.dwell");
  ChainWriter writer = *ChainWriter::create(path, ChainSort::run, kOrigin, service_key());
  ASSERT_TRUE(writer.append("run", 1, "a"));
  ASSERT_TRUE(writer.commit());
  // A limit on the size of files stands for the disk: writes beyond it fail.
  ::signal(SIGXFSZ, SIG_IGN);
  struct rlimit free {};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &free), 0);
  const struct rlimit full { 1 << 20, free.rlim_max };
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &full), 0);
  Result<void> done = writer.append("stream", 2, noise(4 << 20, 3));
  if (done) done = writer.commit();
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &free), 0);
  EXPECT_FALSE(done);
  EXPECT_EQ(writer.committed(), 1);
  EXPECT_EQ(read_all(path)->size(), 1u);
  ASSERT_TRUE(writer.append("event", 3, "b"));
  ASSERT_TRUE(writer.commit());
  EXPECT_EQ(read_all(path)->size(), 2u);
  EXPECT_EQ(read_all(path)->back().head, writer.committed_head());
}

TEST(ChainFile, AnEntryThatNoReaderWouldTakeIsRefused) {
  const Scratch scratch;
  ChainWriter writer = *ChainWriter::create(scratch.path("a.dwell"), ChainSort::run, kOrigin, service_key());
  EXPECT_FALSE(writer.append("stream", 2, std::string(static_cast<std::size_t>(ChainReader::kMaxBody) + 1, 'x')));
}

}  // namespace
}  // namespace dwell::record
