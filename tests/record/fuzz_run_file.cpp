// Whatever a run file holds, its reader answers: what it holds, or one line about what is wrong. The input is the file
// itself; or, where it does not begin as a database does, changes to a small run file: three bytes each, two for the
// place and one for what comes there.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <string>

#include "daemon/record/block.hpp"
#include "daemon/record/chain_file.hpp"
#include "daemon/record/run_reader.hpp"
#include "tests/record/scratch.hpp"

namespace {

using namespace dwell::record;

void hold(bool promise) {
  if (!promise) std::abort();
}

template <class T>
void check(const Result<T>& result, const std::string& path) {
  if (result) return;
  hold(result.error().starts_with(path + ": ") && result.error().find('\n') == std::string::npos);
}

// A run of two blocks with everything that a file may hold, in 40 kB.
std::string small_run(const Scratch& scratch) {
  const std::string path = scratch.path("small.dwell");
  auto writer = ChainWriter::create(path, ChainSort::run, "dwell/run/x", *SigningKey::make("rig"));
  hold(writer.has_value());
  std::vector<dwell::Record> records(100);
  for (std::size_t i = 0; i < records.size(); ++i) {
    records[i].t_ns = static_cast<std::int64_t>(1000 * i);
    records[i].value = static_cast<double>(i * i % 1000);
    records[i].channel = static_cast<std::uint16_t>(i % 8);
  }
  RunHeader header;
  header.person = Person{.uid = 1000, .name = "anna"};
  header.files = {{.path = "a.dbc", .sha256 = "00", .text = "\xFF"}};
  header.plugins = {{.driver = "can", .version = "1"}};
  header.channels = {"m1"};
  hold(writer->append("run", 0, to_json(header)).has_value());
  hold(writer->append("stream", 1'000'000, encode_block(records)).has_value());
  hold(writer->commit().has_value());
  hold(writer->append("result", 0, to_json(StoredResult{.position = 1, .final = true, .dwell = "{\"a\":[1]}"}))
           .has_value());
  hold(writer->append("event", 0, to_json(StoredEvent{})).has_value());
  hold(writer->append("stream", 2'000'000, encode_block(records)).has_value());
  hold(writer->append("end", 0, to_json(RunEnd{})).has_value());
  hold(writer->append("signature", 0, to_json(PersonalSignature{})).has_value());
  hold(writer->close().has_value());
  return Scratch::read(path);
}

void read_all(const std::string& path) {
  auto run = RunReader::open(path);
  check(run, path);
  if (!run) return;
  check(run->stream([](const dwell::Record&) { return true; }), path);
  check(run->stream_from(run->begin_ns() / 2 + run->end_ns() / 2, [](const dwell::Record&) { return true; }), path);
  check(run->results(false, [](const StoredResult& result) { return !result.dwell.empty(); }), path);
  check(run->results(true, [](const StoredResult& result) { return !result.dwell.empty(); }), path);
  check(run->events([](const StoredEvent&) { return true; }), path);
  check(run->models([](const StoredModel& model) { return !model.result.empty(); }), path);
  check(run->signatures(), path);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Scratch scratch;
  static const std::string small = small_run(scratch);
  static const std::string path = scratch.path("run.dwell");
  std::string file(reinterpret_cast<const char*>(data), size);
  if (!file.starts_with("SQLite format 3")) {
    file = small;
    for (std::size_t i = 0; i + 3 <= size; i += 3)
      file[(data[i] | static_cast<std::size_t>(data[i + 1]) << 8U) % file.size()] = static_cast<char>(data[i + 2]);
  }
  std::ofstream(path, std::ios::binary | std::ios::trunc) << file;
  read_all(path);

  const std::string body(reinterpret_cast<const char*>(data), size);
  (void)parse_run_header(body);
  (void)parse_result(body);
  (void)parse_event(body);
  (void)parse_model("estimate", body);
  (void)parse_run_end(body);
  (void)parse_personal_signature(body);
  return 0;
}
