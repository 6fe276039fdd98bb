#include "daemon/record/run_reader.hpp"

#include <gtest/gtest.h>

#include <functional>

#include "daemon/record/block.hpp"
#include "daemon/record/chain_file.hpp"
#include "tests/record/scratch.hpp"

namespace dwell::record {
namespace {

// A run file written by hand: block k holds ten records, at k seconds and then each 0.1 s.
class WrittenRun {
 public:
  WrittenRun() : writer_(*ChainWriter::create(path(), ChainSort::run, "dwell/run/x", *SigningKey::make("rig"))) {}

  [[nodiscard]] std::string path() const { return scratch_.path("run.dwell"); }
  void header() {
    RunHeader header;
    header.label = "by hand";
    entry("run", 0, to_json(header));
  }
  void block(int k) {
    std::vector<Record> records(10);
    for (int i = 0; i < 10; ++i) {
      records[static_cast<std::size_t>(i)].t_ns = 1'000'000'000LL * k + 100'000'000LL * i;
      records[static_cast<std::size_t>(i)].value = 10 * k + i;
    }
    entry("stream", records.back().t_ns, encode_block(records));
  }
  void entry(const std::string& kind, std::int64_t t_ns, const std::string& body) {
    const auto appended = writer_.append(kind, t_ns, body);
    if (!appended) throw std::runtime_error(appended.error());
  }
  [[nodiscard]] Result<RunReader> read() {
    if (const auto closed = writer_.close(); !closed) return tl::unexpected(closed.error());
    return RunReader::open(path());
  }

 private:
  Scratch scratch_;
  ChainWriter writer_;
};

std::vector<double> values_from(RunReader& run, std::int64_t t_ns) {
  std::vector<double> values;
  const auto read = run.stream_from(t_ns, [&](const Record& record) {
    values.push_back(record.value);
    return true;
  });
  EXPECT_TRUE(read) << read.error();
  return values;
}

TEST(RunReader, ReadsTheWholeStreamInOrder) {
  for (const int blocks : {0, 1, 2, 3, 4, 7, 8, 9, 33}) {
    WrittenRun written;
    written.header();
    for (int k = 0; k < blocks; ++k) {
      written.block(k);
      if (k % 3 == 1) written.entry("result", 0, to_json(StoredResult{.position = 1, .final = false, .dwell = "{}"}));
    }
    auto run = written.read();
    ASSERT_TRUE(run) << run.error();
    EXPECT_EQ(run->header().label, "by hand");
    EXPECT_FALSE(run->end());
    EXPECT_EQ(run->begin_ns(), 0);
    EXPECT_EQ(run->end_ns(), blocks == 0 ? 0 : 1'000'000'000LL * blocks - 100'000'000) << blocks;
    double next = 0;
    const auto read = run->stream([&](const Record& record) {
      EXPECT_EQ(record.value, next);
      ++next;
      return true;
    });
    ASSERT_TRUE(read) << read.error();
    EXPECT_EQ(next, 10 * blocks);
  }
}

TEST(RunReader, BeginsWithTheBlockThatHoldsTheInstant) {
  WrittenRun written;
  written.header();
  for (int k = 0; k < 20; ++k) {
    written.block(k);
    for (int i = 0; i < k % 4; ++i) written.entry("event", 0, to_json(StoredEvent{}));
  }
  auto run = written.read();
  ASSERT_TRUE(run) << run.error();
  EXPECT_EQ(values_from(*run, -5).front(), 0);
  for (int k = 0; k < 20; ++k) {
    EXPECT_EQ(values_from(*run, 1'000'000'000LL * k).front(), 10 * k);
    EXPECT_EQ(values_from(*run, 1'000'000'000LL * k + 900'000'000).front(), 10 * k);
    EXPECT_EQ(values_from(*run, 1'000'000'000LL * k + 900'000'000).back(), 199);
  }
  EXPECT_TRUE(values_from(*run, 19'900'000'001).empty());
}

TEST(RunReader, StopsWhereItIsTold) {
  WrittenRun written;
  written.header();
  written.block(0);
  written.block(1);
  auto run = written.read();
  ASSERT_TRUE(run) << run.error();
  int taken = 0;
  ASSERT_TRUE(run->stream([&](const Record&) { return ++taken < 3; }));
  EXPECT_EQ(taken, 3);
}

TEST(RunReader, ReadsResultsEventsEndAndSignatures) {
  WrittenRun written;
  written.header();
  written.block(0);
  written.entry("result", 0, to_json(StoredResult{.position = 4, .final = false, .dwell = R"({"a":1})"}));
  StoredEvent event;
  event.position = 5;
  written.entry("event", 0, to_json(event));
  written.entry("a kind to come", 0, "?");
  written.entry("result", 0, to_json(StoredResult{.position = 9, .final = true, .dwell = R"({"final":false})"}));
  written.entry("end", 0, to_json(RunEnd{.why = "operator", .records = 10, .samples = 10, .utc = "u"}));
  for (const char* name : {"Anna", "Ben"}) {
    PersonalSignature signature;
    signature.name = name;
    written.entry("signature", 0, to_json(signature));
  }
  auto run = written.read();
  ASSERT_TRUE(run) << run.error();
  ASSERT_TRUE(run->end());
  EXPECT_EQ(run->end()->why, "operator");
  std::vector<std::uint64_t> all, finals, events;
  ASSERT_TRUE(run->results(false, [&](const StoredResult& r) { return all.push_back(r.position), true; }));
  ASSERT_TRUE(run->results(true, [&](const StoredResult& r) { return finals.push_back(r.position), true; }));
  ASSERT_TRUE(run->events([&](const StoredEvent& e) { return events.push_back(e.position), true; }));
  EXPECT_EQ(all, (std::vector<std::uint64_t>{4, 9}));
  EXPECT_EQ(finals, (std::vector<std::uint64_t>{9}));
  EXPECT_EQ(events, (std::vector<std::uint64_t>{5}));
  const auto signatures = run->signatures();
  ASSERT_TRUE(signatures) << signatures.error();
  ASSERT_EQ(signatures->size(), 2U);
  EXPECT_EQ((*signatures)[1].name, "Ben");
}

// What follows the name of the file.
std::string refusal(const std::function<void(WrittenRun&)>& write) {
  WrittenRun written;
  write(written);
  auto run = written.read();
  std::string error = run ? "" : run.error();
  if (run) {
    const auto read = run->stream([](const Record&) { return true; });
    if (!read) error = read.error();
  }
  EXPECT_EQ(error.substr(0, written.path().size() + 2), written.path() + ": ");
  return error.substr(std::min(error.size(), written.path().size() + 2));
}

TEST(RunReader, NamesTheFileTheEntryAndWhatIsWrong) {
  EXPECT_EQ(refusal([](WrittenRun& run) { run.block(0); }),
            "entry 1: is not of the kind \"run\"; expected the \"run\" entry first");
  EXPECT_EQ(refusal([](WrittenRun& run) { run.entry("run", 0, "{}"); }), "entry 1: run entry: \"run\" is missing");
  const auto second_block = [](WrittenRun& run) {
    run.header();
    run.block(0);
    run.entry("stream", 1, "short");
  };
  EXPECT_EQ(refusal(second_block), "entry 3: block of 5 bytes: a block has at least 8");
  EXPECT_EQ(RunReader::open("/there/is/no/such.dwell").error().find("/there/is/no/such.dwell: "), 0U);
}

// SQLite repeats the text of a schema that it cannot read.
TEST(RunReader, AMessageIsOneLineWhateverTheFileHolds) {
  WrittenRun written;
  written.header();
  ASSERT_TRUE(written.read());
  std::string file = Scratch::read(written.path());
  const std::size_t at = file.find("INTEGER");
  ASSERT_NE(at, std::string::npos);
  file[at + 4] = '\n';
  std::ofstream(written.path(), std::ios::binary | std::ios::trunc) << file;
  const auto run = RunReader::open(written.path());
  ASSERT_FALSE(run);
  EXPECT_EQ(run.error().find('\n'), std::string::npos) << run.error();
  EXPECT_NE(run.error().find("INTE?ER"), std::string::npos) << run.error();
}

}  // namespace
}  // namespace dwell::record
