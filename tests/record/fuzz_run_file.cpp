// Whatever a run file, its -wal or a ledger holds, reader and audit answer: what it holds, or one line about what is
// wrong. The input is the file itself, followed by its -wal where the magic number of one stands. If it does not begin
// as a database does, it says what is changed in a small sample: one byte for which of three (a closed run, one that
// was cut off with its -wal, a ledger), then four bytes for each change, three for the place and one for what comes
// there.
//
// The samples are made as the fuzzer starts. Where DWELL_FUZZ_SEEDS names a folder, they are written there as seeds.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "daemon/record/audit.hpp"
#include "daemon/record/block.hpp"
#include "daemon/record/chain_file.hpp"
#include "daemon/record/instants.hpp"
#include "daemon/record/ledger.hpp"
#include "daemon/record/run_reader.hpp"
#include "daemon/record/signature.hpp"
#include "tests/record/scratch.hpp"

namespace {

using namespace dwell::record;

void hold(bool promise) {
  if (!promise) std::abort();
}

bool one_line(const std::string& text) { return !text.empty() && text.find('\n') == std::string::npos; }

template <class T>
void check(const Result<T>& result, const std::string& path) {
  if (!result) hold(result.error().starts_with(path + ": ") && one_line(result.error()));
}

// A file and its -wal; empty: it has none.
struct Pair {
  std::string file, log;
};

class Samples {
 public:
  Samples() {
    write_run("closed.dwell", true);
    write_run("open.dwell", false);
    write_ledger();
    // What no audit would follow to its end is no sample.
    hold(audit_run(path("closed.dwell"), ledgered()).value().state == AuditState::intact);
    closed_ = {Scratch::read(path("closed.dwell")), {}};
    ledger_ = {Scratch::read(path("ledger.dwell-ledger")), {}};
    put(open_);
    hold(audit_run(path("run.dwell"), {}).value().state == AuditState::open);
  }

  // A sample with changes, or the input itself.
  [[nodiscard]] Pair made_of(const std::string& input) const {
    if (input.starts_with("SQLite format 3")) {
      std::size_t log = input.find("\x37\x7f\x06\x82");
      log = std::min(log, input.find("\x37\x7f\x06\x83"));
      return {input.substr(0, log), log == std::string::npos ? std::string() : input.substr(log)};
    }
    Pair made = input.empty() ? closed_ : sample(input[0]);
    for (std::size_t i = 1; i + 4 <= input.size(); i += 4) {
      const auto byte = [&](std::size_t at) { return static_cast<std::size_t>(static_cast<unsigned char>(input[at])); };
      const std::size_t at = (byte(i) | byte(i + 1) << 8U | byte(i + 2) << 16U) % (made.file.size() + made.log.size());
      (at < made.file.size() ? made.file[at] : made.log[at - made.file.size()]) = input[i + 3];
    }
    return made;
  }
  // As run.dwell.
  void put(const Pair& pair) const {
    (void)scratch_.write("run.dwell", pair.file);
    std::filesystem::remove(path("run.dwell-wal"));
    if (!pair.log.empty()) (void)scratch_.write("run.dwell-wal", pair.log);
  }
  [[nodiscard]] std::string path(const std::string& name) const { return scratch_.path(name); }
  [[nodiscard]] AuditOptions ledgered() const { return with_ledger(path("ledger.dwell-ledger")); }
  [[nodiscard]] AuditOptions with_ledger(const std::string& ledger) const {
    AuditOptions options;
    options.keys = {key_.public_key()};
    options.ledger = ledger;
    return options;
  }
  void write_seeds(const std::filesystem::path& folder) const {
    std::filesystem::create_directories(folder);
    std::ofstream(folder / "closed.dwell", std::ios::binary) << closed_.file;
    std::ofstream(folder / "open.dwell", std::ios::binary) << open_.file << open_.log;
    std::ofstream(folder / "ledger.dwell-ledger", std::ios::binary) << ledger_.file;
  }

 private:
  [[nodiscard]] const Pair& sample(char which) const {
    const int one = static_cast<unsigned char>(which) % 3;
    return one == 0 ? closed_ : one == 1 ? open_ : ledger_;
  }

  // A run of two blocks with everything that a file may hold.
  void write_run(const std::string& name, bool closed) {
    auto created = ChainWriter::create(path(name), ChainSort::run, "dwell/run/" + header().id, key_);
    hold(created.has_value());
    std::optional<ChainWriter> writer = std::move(*created);
    std::vector<dwell::Record> records(100);
    for (std::size_t i = 0; i < records.size(); ++i) {
      records[i].t_ns = static_cast<std::int64_t>(1000 * i);
      records[i].value = static_cast<double>(i * i % 1000);
      records[i].channel = static_cast<std::uint16_t>(i % 8);
    }
    const auto append = [&](const char* kind, const std::string& body) {
      hold(writer->append(kind, 1'000'000, body).has_value());
    };
    append("run", to_json(header()));
    append("stream", encode_block(records));
    hold(writer->commit().has_value());
    append("result", to_json(StoredResult{.position = 1, .final = true, .dwell = "{\"a\":[1]}"}));
    append("event", to_json(StoredEvent{}));
    append("estimate", to_json(StoredModel{"estimate", 1, {}, "{\"last\":1}", "{\"motion\":null}"}));
    append("stream", encode_block(records));
    hold(writer->commit().has_value());
    if (!closed) {
      open_ = {Scratch::read(path(name)), Scratch::read(path(name + "-wal"))};
      return;
    }
    append("end", to_json(RunEnd{}));
    hold(writer->close().has_value());
    writer.reset();
    PersonalSignature words{"Anna", "reviewed", "", "2026-11-24T08:00:00Z", 0, "", Person{1000, "anna"}, "", ""};
    hold(sign_by_service(path(name), words, key_).has_value());
    words.person.reset();
    hold(sign_by_own_key(path(name), words, own_).has_value());
  }
  void write_ledger() const {
    auto ledger = Ledger::open(scratch_.path(), key_);
    hold(ledger.has_value() && ledger->run_begins(header(), "closed.dwell").has_value());
    auto rows = ChainReader::open(path("closed.dwell"), ChainSort::run);
    hold(rows.has_value());
    for (auto row = rows->next(); row && *row; row = rows->next())
      if ((*row)->entry.kind == "end")
        hold(ledger->run_ends({header().run, hex((*row)->head), (*row)->entry.seq, "closed"}).has_value());
  }
  [[nodiscard]] RunHeader header() const {
    RunHeader header;
    header.run = 1;
    header.id = std::string(32, 'a');
    header.vkey = key_.public_key().vkey();
    header.person = Person{.uid = 1000, .name = "anna"};
    header.files = {{.path = "a.dbc", .sha256 = "00", .text = "\xFF"}};
    header.plugins = {{.driver = "can", .version = "1"}};
    header.channels = {"m1"};
    return header;
  }

  const Scratch scratch_{true};
  const SigningKey key_ = *SigningKey::make("rig"), own_ = *SigningKey::make("anna");
  Pair closed_, open_, ledger_;
};

const Samples& samples() {
  static const Samples kSamples;
  return kSamples;
}

void read_all(const std::string& path) {
  auto run = RunReader::open(path);
  check(run, path);
  if (!run) return;
  (void)run->ended_utc();
  const auto can_be_computed_with = [](const dwell::Record& record) {
    hold(is_on_clock(record.t_ns));
    return true;
  };
  check(run->stream(can_be_computed_with), path);
  check(run->stream_from(run->begin_ns() / 2 + run->end_ns() / 2, [](const dwell::Record&) { return true; }), path);
  check(run->results(false, [](const StoredResult& result) { return !result.dwell.empty(); }), path);
  check(run->results(true, [](const StoredResult& result) { return !result.dwell.empty(); }), path);
  check(run->events([](const StoredEvent&) { return true; }), path);
  check(run->models([](const StoredModel& model) { return !model.result.empty(); }), path);
  check(run->signatures(), path);
}

void audit(const std::string& path, const AuditOptions& options) {
  const Result<Audit> audit = audit_run(path, options);
  if (!audit) return hold(one_line(audit.error()));
  hold((audit->state == AuditState::tampered) == !audit->where.empty());
  if (!audit->where.empty()) hold(one_line(audit->where));
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* /*count*/, char*** /*arguments*/) {
  if (const char* const folder = std::getenv("DWELL_FUZZ_SEEDS")) samples().write_seeds(folder);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string input(reinterpret_cast<const char*>(data), size);
  const Pair pair = samples().made_of(input);
  samples().put(pair);
  const std::string path = samples().path("run.dwell");
  read_all(path);
  audit(path, {});
  audit(path, samples().ledgered());
  audit(samples().path("closed.dwell"), samples().with_ledger(path));  // a hostile ledger
  // Whoever looks alters nothing.
  hold(Scratch::read(path) == pair.file);
  hold(pair.log.empty() ? !std::filesystem::exists(path + "-wal") : Scratch::read(path + "-wal") == pair.log);

  (void)parse_run_header(input);
  (void)parse_result(input);
  (void)parse_event(input);
  (void)parse_model("estimate", input);
  (void)parse_run_end(input);
  (void)parse_personal_signature(input);
  return 0;
}
