// Property: whatever is done to the bytes of a run file, its audit tells, or every row reads as before.
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "daemon/record/audit.hpp"
#include "tests/record/altered_files.hpp"
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

}  // namespace
}  // namespace dwell::record
