// Keeps what the estimation hands to whoever records, and tells its runs apart.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "daemon/record/stream_sink.hpp"

namespace dwell::test {

struct CollectingSink final : record::StreamSink {
  struct Result {
    std::uint64_t position;
    bool final;
    std::shared_ptr<const Dwell> dwell;
    std::size_t after;  // records of the session so far
  };
  struct Change {
    State before, after;
    std::size_t behind;  // records of the session so far
  };
  // A run as a file of it would hold it.
  struct Run {
    std::vector<Record> records;  // from the birth of its pipeline to its end
    std::vector<Result> results;
    // Changes while it went on: position, the state before and after.
    std::vector<std::tuple<std::uint64_t, State, State>> states;
    std::size_t begins = 0;  // index into records of RunEdge::begins
    bool ended = false;
  };

  void record(const Record& record) noexcept override { records.push_back(record); }
  void result(std::uint64_t position, bool final, std::shared_ptr<const Dwell> dwell) override {
    results.push_back({position, final, std::move(dwell), records.size()});
  }

  void model(std::uint64_t position, record::ModelResult result) override {
    models.emplace_back(position, std::move(result));
  }

  void state(const record::StateChange& change, std::shared_ptr<const Dwell> after) override {
    states.push_back({change.before, after->state, records.size()});
  }

  [[nodiscard]] std::vector<Run> runs() const {
    std::vector<Run> found;
    std::size_t result = 0;
    for (std::size_t i = 0; i < records.size(); ++i) {
      if (!is_edge(records[i], RunEdge::begins)) continue;
      Run run;
      run.begins = static_cast<std::size_t>(records[i].value);
      std::size_t end = i;
      while (end < records.size() && !is_edge(records[end], RunEdge::ends)) ++end;
      run.ended = end < records.size();
      const auto first = records.begin() + static_cast<std::ptrdiff_t>(i - run.begins);
      run.records.assign(first, records.begin() + static_cast<std::ptrdiff_t>(run.ended ? end + 1 : end));
      for (; result < results.size() && results[result].after <= end + 1; ++result)
        run.results.push_back(results[result]);
      for (const Change& change : states)
        if (change.behind > i && change.behind <= end)
          run.states.emplace_back(change.behind - (i - run.begins), change.before, change.after);
      found.push_back(std::move(run));
    }
    return found;
  }

  std::vector<Record> records;
  std::vector<Result> results;
  std::vector<Change> states;
  std::vector<std::pair<std::uint64_t, record::ModelResult>> models;  // with their positions
};

}  // namespace dwell::test
