// Files that are signed and hold instants with which nothing can be computed in 64 bits.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "daemon/record/audit.hpp"
#include "daemon/record/block.hpp"
#include "daemon/record/chain_file.hpp"
#include "daemon/record/run_reader.hpp"
#include "tests/record/altered_files.hpp"

namespace dwell::record {
namespace {

constexpr std::int64_t kEdge_ns = std::int64_t{1} << 61U;  // the first that is too far

struct HostileInstants : testing::Test {
  struct Instants {
    std::int64_t run_ns = 0, block_ns = 1'000, record_ns = 500, end_ns = 1'000;
    const char* start_utc = "2026-11-23T03:12:17Z";
  };
  // A header, two blocks of two records each and an end.
  [[nodiscard]] std::string made(const Instants& of) const {
    std::string path = scratch.path("a.dwell");
    std::filesystem::remove(path);
    RunHeader header = sample_header(1, sample_key());
    header.start_utc = of.start_utc;
    ChainWriter writer = *ChainWriter::create(path, ChainSort::run, "dwell/run/" + header.id, sample_key());
    std::vector<Record> records(2);
    EXPECT_TRUE(writer.append("run", of.run_ns, to_json(header)));
    EXPECT_TRUE(writer.append("stream", 100, encode_block(records)));
    records[1].t_ns = of.record_ns;
    EXPECT_TRUE(writer.append("stream", of.block_ns, encode_block(records)));
    EXPECT_TRUE(writer.append("end", of.end_ns, to_json(RunEnd{})));
    EXPECT_TRUE(writer.close());
    return path;
  }
  // What a reader of everything says; empty: nothing is wrong.
  [[nodiscard]] static std::string read(const std::string& path) {
    auto reader = RunReader::open(path);
    if (!reader) return reader.error();
    (void)reader->ended_utc();
    const Result<void> read = reader->stream([](const Record&) { return true; });
    return read ? std::string() : std::string(read.error());
  }
  [[nodiscard]] static std::string audited(const std::string& path) {
    const Result<Audit> audit = audit_run(path, {});
    EXPECT_TRUE(audit) << audit.error();
    return audit ? std::string(to_string(audit->state)) + ": " + audit->where : std::string();
  }
  Scratch scratch;
};

TEST_F(HostileInstants, OfEntriesAreNamedByReaderAndAudit) {
  for (const std::int64_t far_ns : {INT64_MIN, INT64_MAX, kEdge_ns, -kEdge_ns}) {
    const std::string what =
        "its instant is " + std::to_string(far_ns) + " ns; expected less than 2^61 ns (73 years) from the clock's zero";
    for (const auto& [instants, entry] : std::vector<std::pair<Instants, int>>{
             {{.run_ns = far_ns}, 1}, {{.block_ns = far_ns}, 3}, {{.end_ns = far_ns}, 4}}) {
      const std::string path = made(instants), place = "entry " + std::to_string(entry) + ": ";
      EXPECT_EQ(read(path), path + ": " + place + what);
      EXPECT_EQ(audited(path), "tampered: after entry " + std::to_string(entry - 1) + ": " + place + what);
    }
  }
}

TEST_F(HostileInstants, OfRecordsAreNamedByTheReader) {
  for (const std::int64_t far_ns : {INT64_MIN, INT64_MAX, kEdge_ns, -kEdge_ns}) {
    const std::string path = made({.record_ns = far_ns});
    EXPECT_EQ(read(path), path + ": entry 3: record 2 of its block: its instant is " + std::to_string(far_ns) +
                              " ns; expected less than 2^61 ns (73 years) from the clock's zero");
  }
}

TEST_F(HostileInstants, OfTheBeginInUtcAreNamed) {
  for (const char* far : {"9999-12-31T23:59:59Z", "2262-04-12T00:00:00Z", "1677-01-01T00:00:00Z"}) {
    const std::string path = made({.start_utc = far});
    EXPECT_EQ(read(path), path + ": entry 1: run entry: start_utc: \"" + far +
                              "\" is too far away: expected an instant of the years 1824 to 2115");
    EXPECT_EQ(audited(path), std::string("tampered: entry 1: run entry: start_utc: \"") + far +
                                 "\" is too far away: expected an instant of the years 1824 to 2115");
  }
}

TEST_F(HostileInstants, AreReadUpToTheLastThatIsNot) {
  for (const std::int64_t last_ns : {kEdge_ns - 1, 1 - kEdge_ns}) {
    const std::string path = made({-last_ns, last_ns, last_ns, last_ns, "2115-12-31T23:59:59Z"});
    EXPECT_EQ(read(path), "");
    EXPECT_EQ(audited(path), "intact: ");
  }
}

}  // namespace
}  // namespace dwell::record
