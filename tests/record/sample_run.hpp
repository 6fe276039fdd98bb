// A run file as the service leaves it, written by the record's own code: what the tests of its readers are about.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/stream/record.hpp"
#include "daemon/record/keys.hpp"
#include "daemon/record/run_entries.hpp"

namespace dwell::record {

struct SampleRun {
  std::string path;
  RunHeader header;
  std::vector<Record> stream;
  std::vector<StoredResult> results;
  std::vector<StoredModel> models = {};
  std::vector<StoredEvent> events;
  bool closed = true;
};

// 20 s of two channels at 100 Hz with ticks, a gap, a loss and a fault, seeded; an operator's run with a label. dwell:
// JSON of the one result.
[[nodiscard]] SampleRun sample_run_file(const std::string& path, const SigningKey& key, const std::string& dwell);

// Writes it: a block a second, each committed. Throws where that fails.
void write(const SampleRun& run, const SigningKey& key);

[[nodiscard]] SigningKey sample_key(const std::string& name);

}  // namespace dwell::record
