// A run log whose runs stay in memory, and the stream that it is handed.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>

#include "daemon/record/block.hpp"
#include "daemon/record/run_log.hpp"
#include "tests/record/synthetic_stream.hpp"

namespace dwell::record {

struct MemoryRun {
  RunHeader header;
  std::vector<NewEntry> entries;
  bool closed = false;
};

// A disk in memory. Where it is full it takes nothing but what the reserve is for.
class MemoryStore final : public RunStore {
 public:
  Result<void> ready() override { return verdict(); }
  Result<void> begin(RunHeader& header, std::int64_t /*t_ns*/, std::span<const NewEntry> first) override {
    if (auto can = verdict(); !can) return can;
    header.run = static_cast<std::int64_t>(runs.size()) + 1;
    runs.push_back({header, {first.begin(), first.end()}, false});
    return {};
  }
  Result<void> write(std::span<const NewEntry> batch) override {
    if (auto can = verdict(); !can) return can;
    runs.back().entries.insert(runs.back().entries.end(), batch.begin(), batch.end());
    ++commits;
    return {};
  }
  Result<void> end(std::span<const NewEntry> last) override {
    if (broken) return tl::unexpected(std::string("input/output error"));
    runs.back().entries.insert(runs.back().entries.end(), last.begin(), last.end());
    runs.back().closed = true;
    return {};
  }
  Result<void> verdict() const {
    if (full) return tl::unexpected(std::string("disk full"));
    return {};
  }

  std::vector<MemoryRun> runs;
  int commits = 0;
  bool full = false, broken = false;
};

struct LoggedRuns : testing::Test {
  LoggedRuns()
      : log(store, {[] { return RunHeader(); },
                    [this](const Dwell&, const std::string& utc) { return "{\"t\":\"" + utc + "\"" + more + "}"; },
                    [](const ModelResult&) {
                      return StoredModel{"estimate", 0, {}, R"({"last":19})", R"({"motion":null})"};
                    },
                    [](State before, const Dwell& after) {
                      return std::string(to_string(before)) + " -> " + to_string(after.state);
                    },
                    [this](const Notice& notice) { notices.push_back(notice); },
                    {{"y0", "y1"}, {"amplifier"}}}),
        stream(2, 200.0, [this](const Record& record) {
          log.set_clock({record.t_ns, kUtc_ns + record.t_ns});
          handed.push_back(record);
          log.record(record);
          if (!behind) log.caught_up();
        }) {}

  static std::vector<Record> records_of(const MemoryRun& run) {
    std::vector<Record> all, some;
    for (const NewEntry& entry : run.entries) {
      if (entry.kind != "stream") continue;
      EXPECT_TRUE(decode_block(entry.body, some));
      all.insert(all.end(), some.begin(), some.end());
    }
    return all;
  }
  static std::vector<StoredEvent> events_of(const MemoryRun& run) {
    std::vector<StoredEvent> events;
    for (const NewEntry& entry : run.entries)
      if (entry.kind == "event") events.push_back(*parse_event(entry.body));
    return events;
  }
  static RunEnd end_of(const MemoryRun& run) { return *parse_run_end(run.entries.back().body); }
  // The stream as handed in, from the birth of the run's pipeline on, so many records.
  void expect_stream(const MemoryRun& run, std::size_t from, std::size_t count) const {
    const auto records = records_of(run);
    ASSERT_EQ(records.size(), count);
    for (std::size_t i = 0; i < count; ++i) {
      ASSERT_EQ(records[i].t_ns, handed[from + i].t_ns) << i;
      ASSERT_EQ(records[i].kind, handed[from + i].kind) << i;
      ASSERT_EQ(records[i].value, handed[from + i].value) << i;
    }
  }
  [[nodiscard]] bool told(const std::string& part) const {
    return std::any_of(notices.begin(), notices.end(),
                       [&](const Notice& n) { return n.text.find(part) != std::string::npos; });
  }

  static constexpr std::int64_t kUtc_ns = 1'790'000'000'000'000'000;
  MemoryStore store;
  std::string more;     // in each dwell's JSON
  bool behind = false;  // the log has not read the stream to its end
  std::vector<Notice> notices;
  std::vector<Record> handed;
  RunLog log;
  SyntheticStream stream;
};

}  // namespace dwell::record
