#include "tests/record/altered_files.hpp"

#include <cmath>
#include <filesystem>
#include <random>
#include <stdexcept>
#include <utility>

#include "daemon/record/block.hpp"
#include "daemon/record/signature.hpp"
#include "daemon/record/sqlite.hpp"

namespace dwell::record {
namespace {

void must(const Result<void>& done) {
  if (!done) throw std::runtime_error(done.error());
}

template <class T>
T must(Result<T> done) {
  if (!done) throw std::runtime_error(done.error());
  return std::move(*done);
}

std::vector<Record> sample_block(std::mt19937& random, int count, std::int64_t& t_ns) {
  std::vector<Record> records;
  for (int i = 0; i < count; ++i) {
    t_ns += 1'000'000;
    Record record;
    record.t_ns = t_ns;
    record.stamped_ns = t_ns + static_cast<std::int64_t>(random() % 5000);
    record.value = std::round(1000.0 * std::sin(1e-8 * static_cast<double>(t_ns)) + static_cast<double>(random() % 30));
    record.t_half_ns = 50'000;
    record.kind = i % 10 == 9 ? Kind::tick : Kind::sample;
    if (record.kind == Kind::tick) record = Record{.t_ns = t_ns, .kind = Kind::tick};
    records.push_back(record);
  }
  return records;
}

PersonalSignature sample_signature(const std::string& meaning) {
  PersonalSignature signature;
  signature.name = "Anna Huber";
  signature.meaning = meaning;
  signature.reason = "for the customer";
  signature.utc = "2026-11-24T08:00:00.000000Z";
  return signature;
}

void sign_by_person(const std::string& path, bool service) {
  PersonalSignature signature = sample_signature(service ? "reviewed" : "released");
  if (service) signature.person = Person{1000, "anna"};
  (void)must(service ? sign_by_service(path, signature, sample_key())
                     : sign_by_own_key(path, signature, sample_other()));
}

}  // namespace

const SigningKey& sample_key() {
  static const SigningKey kKey = *SigningKey::make("rig-7");
  return kKey;
}

const SigningKey& sample_other() {
  static const SigningKey kKey = *SigningKey::make("somebody");
  return kKey;
}

PersonalSignature sample_words() {
  PersonalSignature words;
  words.name = "Anna";
  words.meaning = "reviewed";
  words.utc = "2026-11-24T08:00:00.000000Z";
  return words;
}

RunHeader sample_header(std::int64_t run, const SigningKey& key) {
  RunHeader header;
  header.run = run;
  header.id = std::string(28, 'a') + std::to_string(1000 + run);
  header.label = "sweep";
  header.begun_by = "drive";
  header.start_utc = "2026-11-23T03:12:17.250000Z";
  header.vkey = key.public_key().vkey();
  header.rig = {"rig.toml", std::string(64, '0'), "[rig]\nname = \"seven\"\n"};
  header.channels = {"table", "mass1"};
  return header;
}

std::string write_sample(const std::string& path, SampleFile run, const SigningKey& key) {
  std::mt19937 random(run.seed);
  if (run.header.id.empty()) run.header = sample_header(1 + run.seed, key);
  std::int64_t t_ns = 1'000'000'000;
  std::optional<ChainWriter> file = must(ChainWriter::create(path, ChainSort::run, "dwell/run/" + run.header.id, key));
  must(file->append("run", t_ns, to_json(run.header)));
  for (int i = 0; i < run.blocks; ++i) {
    must(file->append("stream", t_ns, encode_block(sample_block(random, run.records, t_ns))));
    if (i % 2 == 0)
      must(file->append("event", t_ns,
                        to_json(StoredEvent{.position = 7,
                                            .utc = "2026-11-23T03:12:18Z",
                                            .what = "state",
                                            .text = "settling",
                                            .person = {},
                                            .before = {},
                                            .after = {},
                                            .comment = {}})));
    if (i % 3 == 0)
      must(file->append("result", t_ns,
                        to_json(StoredResult{.position = 9, .final = i == 3, .dwell = R"({"frequency_hz":1.5})"})));
    must(file->commit());
  }
  if (run.end == SampleEnd::log_left) {
    // A copy of the files as they lie on the disk is what a crash leaves.
    std::filesystem::copy_file(path, path + ".kept");
    std::filesystem::copy_file(path + "-wal", path + ".kept-wal");
    std::string head = hex(file->committed_head());
    file.reset();
    std::filesystem::rename(path + ".kept", path);
    std::filesystem::rename(path + ".kept-wal", path + "-wal");
    return head;
  }
  if (run.end == SampleEnd::log_folded) return hex(file->committed_head());
  must(file->append("end", t_ns, to_json(RunEnd{"operator", 5, sample_count(run), "2026-11-23T03:13:00Z"})));
  must(file->close());
  std::string head = hex(file->committed_head());
  file.reset();
  if (run.end == SampleEnd::signed_by_service || run.end == SampleEnd::signed_by_both) sign_by_person(path, true);
  if (run.end == SampleEnd::signed_by_own_key || run.end == SampleEnd::signed_by_both) sign_by_person(path, false);
  return head;
}

std::uint64_t sample_count(const SampleFile& run) {
  return static_cast<std::uint64_t>(run.blocks) * static_cast<std::uint64_t>(run.records - run.records / 10);
}

std::vector<std::string> rows_of(const std::string& path, ChainSort sort) {
  std::vector<std::string> rows;
  Result<ChainReader> reader = ChainReader::open(path, sort);
  if (!reader) return {"unreadable"};
  for (;;) {
    const auto row = reader->next();
    if (!row) return {"unreadable"};
    if (!*row) return rows;
    const Entry& entry = (*row)->entry;
    rows.push_back(std::to_string(entry.seq) + " " + entry.kind + " " + std::to_string(entry.t_ns) + " " +
                   hex((*row)->head) + " " + (*row)->note + " " + entry.body);
  }
}

Files files_in(const Scratch& scratch) {
  Files files;
  for (const auto& file : std::filesystem::directory_iterator(scratch.path()))
    files[file.path().filename().string()] = Scratch::read(file.path().string());
  return files;
}

void put_files(const Scratch& scratch, const Files& files) {
  for (const auto& file : std::filesystem::directory_iterator(scratch.path())) std::filesystem::remove(file.path());
  for (const auto& [name, bytes] : files) scratch.write(name, bytes);
}

bool forge(const std::string& path, const std::string& sql) {
  sqlite3* opened = nullptr;
  sqlite3_open(path.c_str(), &opened);
  const Database database(opened);
  return execute(opened, ("PRAGMA synchronous = OFF; " + sql).c_str());
}

void forge_heads(const std::string& path) {
  sqlite3* opened = nullptr;
  sqlite3_open(path.c_str(), &opened);
  const Database database(opened);
  (void)execute(opened, "PRAGMA synchronous = OFF; BEGIN");
  const Statement rows = prepare(opened, "SELECT seq, kind, t_ns, body FROM entry ORDER BY seq");
  std::vector<std::pair<std::int64_t, Digest>> heads;
  Digest head{};
  while (sqlite3_step(rows.get()) == SQLITE_ROW) {
    const Entry entry{sqlite3_column_int64(rows.get(), 0), std::string(column_bytes(rows.get(), 1)),
                      sqlite3_column_int64(rows.get(), 2), std::string(column_bytes(rows.get(), 3))};
    head = next_head(head, entry);
    heads.emplace_back(entry.seq, head);
  }
  for (const auto& [seq, value] : heads)
    (void)execute(opened, ("UPDATE entry SET head = x'" + hex(value) + "' WHERE seq = " + std::to_string(seq)).c_str());
  (void)execute(opened, "COMMIT");
}

}  // namespace dwell::record
