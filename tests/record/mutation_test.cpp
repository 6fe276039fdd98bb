// Property: whatever is done to the bytes of a run file or a ledger, its audit tells, or every row reads as before.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "daemon/record/anchor.hpp"
#include "daemon/record/audit.hpp"
#include "daemon/record/ledger.hpp"
#include "daemon/record/run_reader.hpp"
#include "tests/record/altered_files.hpp"
#include "tests/record/audited.hpp"
#include "tests/under_sanitizer.hpp"

namespace dwell::record {
namespace {

constexpr SampleEnd kSampleEnds[] = {
    SampleEnd::closed,         SampleEnd::signed_by_service, SampleEnd::signed_by_own_key,
    SampleEnd::signed_by_both, SampleEnd::log_left,          SampleEnd::log_folded};

bool is_open(SampleEnd end) { return end == SampleEnd::log_left || end == SampleEnd::log_folded; }

// An untouched file: its bytes and what is seen of it.
struct Original {
  SampleEnd end = SampleEnd::closed;
  Files files;
  std::vector<std::string> rows;
};

std::vector<Original> originals() {
  std::vector<Original> all;
  unsigned seed = 0;
  for (const SampleEnd end : kSampleEnds) {
    for (const int records : {30, 4000}) {
      const Scratch scratch(true);
      write_sample(scratch.path("a.dwell"), {.seed = ++seed, .end = end, .blocks = 8, .records = records});
      all.push_back({end, files_in(scratch), rows_of(scratch.path("a.dwell"))});
    }
  }
  return all;
}

// What was done, and whether that is a cut of the tail: then fewer rows may read as an open run.
struct Mutation {
  std::string what;
  bool cut = false;
};

class Mutator {
 public:
  Mutator(const Scratch& scratch, std::mt19937& random) : scratch_(scratch), random_(random) {}

  // nullopt: this file has nothing of the kind.
  std::optional<Mutation> mutate(const Original& original, const Original& other) {
    put_files(scratch_, original.files);
    switch (below(12)) {
      case 0:
      case 1:
      case 2:
      case 3:
        return flip(original);
      case 4:
        return row(original);
      case 5:
        return note(original);
      case 6:
        return cut_rows(original);
      case 7:
        return truncate(original);
      case 8:
        return append(original);
      case 9:
        return swap_files(other);
      case 10:
        return overwrite(original);
      default:
        return field(original);
    }
  }

 private:
  std::size_t below(std::size_t n) { return random_() % n; }
  std::string some_seq(const Original& original) { return std::to_string(1 + below(original.rows.size())); }
  [[nodiscard]] std::string path() const { return scratch_.path("a.dwell"); }

  std::string some_file(const Original& original) {
    auto file = original.files.begin();
    std::advance(file, static_cast<std::ptrdiff_t>(below(original.files.size())));
    return file->first;
  }

  std::optional<Mutation> flip(const Original& original) {
    const std::string name = some_file(original);
    std::string bytes = original.files.at(name);
    const std::size_t at = below(8 * bytes.size());
    bytes[at / 8] = static_cast<char>(bytes[at / 8] ^ 1 << at % 8);
    scratch_.write(name, bytes);
    return Mutation{"bit " + std::to_string(at % 8) + " of byte " + std::to_string(at / 8) + " of " + name};
  }

  std::optional<Mutation> sql(const std::string& statement, bool cut = false) {
    if (!forge(path(), statement)) return std::nullopt;
    if (rows_of(path()).empty()) return std::nullopt;  // a new file, nobody's run
    return Mutation{statement, cut};
  }

  std::optional<Mutation> row(const Original& original) {
    const std::string a = some_seq(original), b = some_seq(original);
    switch (below(6)) {
      case 0:
        return sql("DELETE FROM entry WHERE seq = " + a, a == std::to_string(original.rows.size()));
      case 1:
        return sql("UPDATE entry SET seq = -seq WHERE seq >= " + a +
                   "; UPDATE entry SET seq = 1 - seq WHERE seq < 0; "
                   "INSERT INTO entry SELECT seq - 1, kind, t_ns, body, head FROM entry WHERE seq = " +
                   a + " + 1");
      case 2:
        return sql(
            "INSERT INTO entry SELECT (SELECT max(seq) + 1 FROM entry), kind, t_ns, body, head FROM entry "
            "WHERE seq = " +
            a);
      case 3:
        if (a == b) return std::nullopt;
        return sql("UPDATE entry SET seq = -1 WHERE seq = " + a + "; UPDATE entry SET seq = " + a +
                   " WHERE seq = " + b + "; UPDATE entry SET seq = " + b + " WHERE seq = -1");
      case 4:
        // Deleted, and all that follow moved up, with their heads computed anew.
        if (!sql("DELETE FROM entry WHERE seq = " + a + "; DELETE FROM note WHERE seq = " + a +
                 "; UPDATE entry SET seq = 1 - seq WHERE seq > " + a + "; UPDATE entry SET seq = -seq WHERE seq < 0"))
          return std::nullopt;
        forge_heads(path());
        return Mutation{"entry " + a + " deleted, heads anew", a == std::to_string(original.rows.size())};
      default:
        if (!sql("UPDATE entry SET body = body || x'00' WHERE seq = " + a)) return std::nullopt;
        forge_heads(path());
        return Mutation{"entry " + a + " longer, heads anew"};
    }
  }

  std::optional<Mutation> field(const Original& original) {
    const std::string a = some_seq(original), where = " WHERE seq = " + a;
    switch (below(7)) {
      case 0:
        return sql("UPDATE entry SET t_ns = t_ns + 1" + where);
      case 1:
        return sql("UPDATE entry SET kind = 'event '" + where);
      case 2:
        return sql("UPDATE entry SET kind = 'other'" + where);
      case 3:
        return sql("UPDATE entry SET head = zeroblob(32)" + where);
      case 4:
        return sql("PRAGMA application_id = 1");
      case 5:
        return sql("CREATE TABLE more (x); INSERT INTO more VALUES (1)");
      default:
        return sql("ALTER TABLE note ADD COLUMN x TEXT");
    }
  }

  std::optional<Mutation> note(const Original& original) {
    const std::string a = some_seq(original), b = some_seq(original), where = " WHERE seq = " + a;
    switch (below(6)) {
      case 0:
        if (original.rows[std::stoul(a) - 1].find("\u2014") == std::string::npos) return std::nullopt;
        return sql("DELETE FROM note" + where, a == std::to_string(original.rows.size()));
      case 1:
        return sql("INSERT INTO note SELECT " + a + ", text FROM note WHERE seq = " + b);
      case 2:
        return sql("INSERT INTO note SELECT 1000, text FROM note LIMIT 1");
      case 3:
        return sql("UPDATE note SET text = text || char(10)");
      case 4:
        return sql("UPDATE note SET text = replace(text, 'A', 'B')");
      default:
        return sql("INSERT INTO note VALUES (" + a + ", '')");
    }
  }

  std::optional<Mutation> cut_rows(const Original& original) {
    const std::size_t a = 2 + below(original.rows.size() - 1);
    const std::string from = std::to_string(a);
    return sql("DELETE FROM entry WHERE seq >= " + from + "; DELETE FROM note WHERE seq >= " + from, true);
  }

  std::optional<Mutation> truncate(const Original& original) {
    const std::string name = some_file(original);
    const std::string& bytes = original.files.at(name);
    const std::size_t size = below(2) == 0 ? below(bytes.size()) : below(bytes.size() / 512) * 512;
    scratch_.write(name, bytes.substr(0, size));
    return Mutation{name + " truncated to " + std::to_string(size), name == "a.dwell-wal"};
  }

  std::optional<Mutation> append(const Original& original) {
    const std::string name = some_file(original);
    std::string more(1 + below(40000), '\0');
    for (char& byte : more) byte = static_cast<char>(random_());
    scratch_.write(name, original.files.at(name) + more);
    return Mutation{std::to_string(more.size()) + " bytes appended to " + name};
  }

  // The log of another file, or its database under this one's log.
  std::optional<Mutation> swap_files(const Original& other) {
    const std::string name = below(2) == 0 ? "a.dwell-wal" : "a.dwell";
    if (!other.files.contains("a.dwell-wal") || (name == "a.dwell" && !files_in(scratch_).contains("a.dwell-wal")))
      return std::nullopt;
    scratch_.write(name, other.files.at(name));
    return Mutation{name + " of another run"};
  }

  std::optional<Mutation> overwrite(const Original& original) {
    std::string bytes = original.files.at("a.dwell");
    const std::size_t at = below(bytes.size());
    for (std::size_t i = at; i < std::min(bytes.size(), at + 1 + below(600)); ++i)
      bytes[i] = static_cast<char>(random_());
    scratch_.write("a.dwell", bytes);
    return Mutation{"bytes from " + std::to_string(at) + " on of a.dwell"};
  }

  const Scratch& scratch_;
  std::mt19937& random_;
};

TEST(Mutation, NoneOfThousandsIsMissed) {
  const std::vector<Original> all = originals();
  const Scratch scratch(true);
  std::mt19937 random(12);
  Mutator mutator(scratch, random);
  int done = 0, found = 0, unchanged = 0, cut = 0;
  while (done < draws(2000, 300)) {
    const Original& original = all[random() % all.size()];
    const Original* other = &all[random() % all.size()];
    if (other == &original) continue;
    const std::optional<Mutation> mutation = mutator.mutate(original, *other);
    if (!mutation || files_in(scratch) == original.files) continue;
    ++done;
    const Result<Audit> audit = audit_run(scratch.path("a.dwell"), {});
    ASSERT_TRUE(audit) << audit.error();
    if (audit->state == AuditState::tampered) {
      EXPECT_FALSE(audit->where.empty());
      ++found;
      continue;
    }
    const std::vector<std::string> rows = rows_of(scratch.path("a.dwell"));
    if (rows == original.rows) {
      EXPECT_EQ(audit->state == AuditState::open, is_open(original.end)) << mutation->what;
      ++unchanged;
      continue;
    }
    if (rows == other->rows) continue;  // all of another run; the ledger tells
    ++cut;
    // What remains without the signatures of persons is a closed run; only the ledger knows that they were there.
    const bool ended = std::any_of(rows.begin(), rows.end(), [](const std::string& r) { return r.find(" end ") < 12; });
    EXPECT_TRUE(mutation->cut) << "missed: " << mutation->what;
    EXPECT_EQ(audit->state, ended ? AuditState::intact : AuditState::open) << mutation->what;
    EXPECT_LT(rows.size(), original.rows.size()) << mutation->what;
    EXPECT_TRUE(std::equal(rows.begin(), rows.end(), original.rows.begin())) << mutation->what;
  }
  std::cout << done << " mutations: " << found << " tampered, " << unchanged << " in unused space, " << cut
            << " cut tails\n";
  EXPECT_GT(found, done / 2);
}

TEST(Mutation, NoUntouchedFileIsReported) {
  unsigned seed = 100;
  for (int i = 0; i < 200; ++i) {
    const SampleEnd end = kSampleEnds[static_cast<std::size_t>(i) % std::size(kSampleEnds)];
    const Scratch scratch(true);
    const SampleFile run{.seed = ++seed, .end = end, .blocks = 1 + i % 7, .records = 1 + 37 * (i % 11)};
    const std::string path = scratch.path("a.dwell");
    write_sample(path, run);
    const Files before = files_in(scratch);
    const Result<Audit> audit =
        audit_run(path, {.keys = {sample_key().public_key()}, .ledger = {}, .anchors = {}, .progress = {}});
    ASSERT_TRUE(audit) << audit.error();
    EXPECT_EQ(audit->state, is_open(end) ? AuditState::open : AuditState::intact) << audit->where;
    EXPECT_TRUE(audit->trusted);
    EXPECT_EQ(audit->samples, sample_count(run));
    EXPECT_EQ(files_in(scratch), before) << "an audit leaves every byte as it was, and no new file";
  }
}

// A run and the ledger that knows its end and its signatures.
struct Ledgered {
  Original run;
  std::unique_ptr<Scratch> beside;  // the ledger's directory
  AuditOptions options;
};

std::vector<Ledgered> ledgered_originals() {
  std::vector<Ledgered> all;
  unsigned seed = 50;
  for (const SampleEnd end : kSampleEnds) {
    const Scratch scratch(true);
    const std::string path = scratch.path("a.dwell");
    Ledgered made{{}, std::make_unique<Scratch>(true), {}};
    made.options = pinned(sample_key());
    made.options.ledger = made.beside->path("ledger.dwell-ledger");
    Ledger ledger = *Ledger::open(made.beside->path(), sample_key());
    const RunHeader header = sample_header(ledger.next_run(), sample_key());
    EXPECT_TRUE(ledger.run_begins(header, "a.dwell"));
    write_sample(path, {.seed = ++seed, .end = end, .blocks = 8, .records = 30, .header = header});
    made.run = {end, files_in(scratch), rows_of(path)};
    auto reader = RunReader::open(path);
    EXPECT_TRUE(reader) << reader.error();
    const auto signatures = reader->signatures();
    EXPECT_TRUE(signatures) << signatures.error();
    // The head of the last entry that is no signature.
    const std::size_t seq = made.run.rows.size() - signatures->size();
    auto rows = ChainReader::open(path, ChainSort::run);
    rows->seek(static_cast<std::int64_t>(seq));
    EXPECT_TRUE(ledger.run_ends(
        {header.run, hex((*rows->next())->head), static_cast<std::int64_t>(seq), is_open(end) ? "cut off" : "closed"}));
    for (const PersonalSignature& signature : *signatures) EXPECT_TRUE(ledger.run_signed(header.run, signature));
    all.push_back(std::move(made));
  }
  return all;
}

// Without the ledger a cut tail reads as open, and signatures can be taken away.
TEST(Mutation, NoneIsMissedWhereTheLedgerKnowsTheRunNotEvenACutTail) {
  const std::vector<Ledgered> all = ledgered_originals();
  const Scratch scratch(true);
  std::mt19937 random(13);
  Mutator mutator(scratch, random);
  for (const Ledgered& one : all) {
    put_files(scratch, one.run.files);
    const Audit audit = audited(scratch.path("a.dwell"), one.options);
    EXPECT_EQ(audit.state, is_open(one.run.end) ? AuditState::open : AuditState::intact) << audit.where;
    EXPECT_TRUE(audit.trusted);
  }
  int done = 0, found = 0, cut = 0;
  while (done < draws(300, 60)) {
    const Ledgered& original = all[random() % all.size()];
    const Ledgered& other = all[random() % all.size()];
    if (&other == &original) continue;
    const std::optional<Mutation> mutation = mutator.mutate(original.run, other.run);
    if (!mutation || files_in(scratch) == original.run.files) continue;
    ++done;
    const Result<Audit> audit = audit_run(scratch.path("a.dwell"), original.options);
    ASSERT_TRUE(audit) << audit.error();
    const bool tampered = audit->state == AuditState::tampered;
    const bool same = rows_of(scratch.path("a.dwell")) == original.run.rows;
    EXPECT_TRUE(tampered || same) << "missed: " << mutation->what;
    EXPECT_TRUE(tampered || audit->trusted) << mutation->what;
    found += tampered ? 1 : 0;
    cut += mutation->cut && !same ? 1 : 0;
  }
  EXPECT_GT(found, done / 2);
  EXPECT_GT(cut, done / 60) << "cut tails were among them";
}

// One of the ways to alter a ledger, in words; nullopt: there is nothing of the kind.
std::optional<std::string> alter_ledger(const Scratch& scratch, const Files& files, std::size_t entries,
                                        std::mt19937& random) {
  const auto below = [&](std::size_t n) { return random() % n; };
  std::vector<std::string> parts;
  for (const auto& [name, bytes] : files)
    if (name.rfind("ledger.dwell-ledger", 0) == 0 && !bytes.empty()) parts.push_back(name);
  const std::string name = parts[below(parts.size())];
  std::string bytes = files.at(name);
  const std::string a = std::to_string(1 + below(entries)), b = std::to_string(1 + below(entries));
  const auto sql = [&](const std::string& statement) -> std::optional<std::string> {
    if (!forge(scratch.path("ledger.dwell-ledger"), statement)) return std::nullopt;
    return statement;
  };
  switch (below(10)) {
    case 0:
      return sql("DELETE FROM entry WHERE seq = " + a + "; DELETE FROM note WHERE seq = " + a);
    case 1:
      return sql("DELETE FROM note WHERE seq = " + a);
    case 2:
      if (a == b) return std::nullopt;
      return sql("UPDATE entry SET seq = -1 WHERE seq = " + a + "; UPDATE entry SET seq = " + a + " WHERE seq = " + b +
                 "; UPDATE entry SET seq = " + b + " WHERE seq = -1");
    case 3: {
      const std::size_t at = below(bytes.size());
      for (std::size_t i = at; i < std::min(bytes.size(), at + 1 + below(600)); ++i)
        bytes[i] = static_cast<char>(random());
      scratch.write(name, bytes);
      return "bytes from " + std::to_string(at) + " on of " + name;
    }
    default: {
      const std::size_t at = below(8 * bytes.size());
      bytes[at / 8] = static_cast<char>(bytes[at / 8] ^ 1 << at % 8);
      scratch.write(name, bytes);
      return "bit " + std::to_string(at % 8) + " of byte " + std::to_string(at / 8) + " of " + name;
    }
  }
}

TEST(Mutation, NoneOfALedgerIsMissedAndWhatItTellsOfRunsStaysTrue) {
  const Scratch scratch(true);
  const std::string path = scratch.path("ledger.dwell-ledger");
  const Scratch elsewhere(true);  // without an anchor, the newest entries can be cut off
  // While the service runs, the newest entries are in the -wal.
  std::vector<Files> originals;
  {
    Ledger ledger = recorded(scratch, 6, true);
    std::filesystem::remove(scratch.path("b.dwell"));
    ASSERT_TRUE(ledger.run_deleted(2, "older than 400 days"));
    ASSERT_TRUE(ledger.run_signed(3, sample_words()));
    originals.push_back(files_in(scratch));
    Anchor head = ledger.head();
    head.utc = "2026-11-24T08:00:00.000000Z";
    elsewhere.write("anchors", to_line(head) + "\n");
  }
  originals.push_back(files_in(scratch));
  ASSERT_TRUE(originals[0].contains("ledger.dwell-ledger-wal"));
  ASSERT_FALSE(originals[1].contains("ledger.dwell-ledger-wal"));
  const std::vector<std::string> rows = rows_of(path, ChainSort::ledger);
  AuditOptions options = pinned(sample_key());
  options.anchors = {elsewhere.path("anchors")};
  for (const Files& files : originals) {
    put_files(scratch, files);
    const auto audit = audit_ledger(path, scratch.path(), options);
    ASSERT_TRUE(audit) << audit.error();
    EXPECT_TRUE(audit->unbroken && audit->trusted && audit->missing.empty()) << audit->where;
  }
  options.ledger = path;
  std::mt19937 random(14);
  int done = 0, found = 0, unchanged = 0;
  while (done < draws(300, 120)) {  // half of 60 touch unused space
    const Files& original = originals[random() % originals.size()];
    put_files(scratch, original);
    const std::optional<std::string> mutation = alter_ledger(scratch, original, rows.size(), random);
    if (!mutation || files_in(scratch) == original) continue;
    ++done;
    const auto audit = audit_ledger(path, scratch.path(), options);
    const bool broken = !audit || !audit->unbroken;  // a ledger that cannot be read at all fails, which is no pass
    EXPECT_FALSE(audit && broken && audit->where.empty()) << *mutation;
    const Result<Audit> run = audit_run(scratch.path("a.dwell"), options);
    if (broken) {
      ++found;
      EXPECT_FALSE(run && run->state == AuditState::intact && run->trusted && run->of_ledger) << *mutation;
      continue;
    }
    ++unchanged;
    const std::vector<std::string> left = rows_of(path, ChainSort::ledger);
    EXPECT_TRUE(left == rows) << "missed: " << *mutation << ": " << left.size() << " of " << rows.size() << " rows";
    ASSERT_TRUE(run) << run.error();
    EXPECT_EQ(run->state, AuditState::intact) << *mutation << ": " << run->where;
    EXPECT_TRUE(run->trusted) << *mutation;
  }
  std::cout << done << " mutations: " << found << " broken, " << unchanged << " in unused space\n";
  EXPECT_GT(found, done / 2);
}

}  // namespace
}  // namespace dwell::record
