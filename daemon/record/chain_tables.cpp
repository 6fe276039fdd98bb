#include "daemon/record/chain_tables.hpp"

#include <algorithm>
#include <cstdlib>
#include <vector>

#include "daemon/record/instants.hpp"

namespace dwell::record {
namespace {

constexpr std::string_view kSelect =
    "SELECT e.seq, e.kind, e.t_ns, e.body, e.head, n.text FROM entry AS e LEFT JOIN note AS n ON n.seq = e.seq "
    "WHERE e.seq >= ?1 ";

std::string text_of(const Digest& digest) {
  return base64({reinterpret_cast<const char*>(digest.data()), digest.size()});
}

std::string sort_of(ChainSort sort) { return sort == ChainSort::run ? "run file" : "ledger"; }

}  // namespace

Result<void> check_tables(sqlite3* database, ChainSort sort) {
  const std::string id = first_text(database, "PRAGMA application_id");
  if (id != std::to_string(static_cast<std::uint32_t>(sort))) {
    if (id.empty()) return fails(sqlite_message(database));
    return fails("no " + sort_of(sort) + ": its application_id is " + id + ", expected " +
                 std::to_string(static_cast<std::uint32_t>(sort)));
  }
  const std::string version = first_text(database, "PRAGMA user_version");
  if (version != std::to_string(kFormatVersion))
    return fails({"a " + sort_of(sort) + " of format " + version + "; this program knows format " +
                      std::to_string(kFormatVersion),
                  std::atoll(version.c_str()) > kFormatVersion ? Cause::newer : Cause::other});

  const Statement schema = prepare(database, "SELECT type, name, sql FROM sqlite_schema ORDER BY name");
  if (!schema) return fails(sqlite_message(database));
  std::vector<std::string> found;
  int code = SQLITE_OK;
  while ((code = sqlite3_step(schema.get())) == SQLITE_ROW && found.size() < 3)
    found.emplace_back(column_bytes(schema.get(), 2));
  if (code != SQLITE_ROW && code != SQLITE_DONE) return fails(sqlite_message(database));
  if (found != std::vector<std::string>{kEntryTable, kNoteTable})
    return fails("its tables are not those of a " + sort_of(sort));
  return {};
}

std::string note_front(const std::string& origin, std::int64_t seq, const Digest& head, std::int64_t t_ns) {
  return origin + "\n" + std::to_string(seq) + "\n" + text_of(head) + "\n" + std::to_string(t_ns) + "\n";
}

std::string note_text(const std::string& origin, std::int64_t seq, const Digest& head, std::int64_t t_ns,
                      const NoteLink& before) {
  return note_front(origin, seq, head, t_ns) + std::to_string(before.seq) + "\n" + text_of(before.hash) + "\n";
}

ChainRows::ChainRows(sqlite3* database, ChainSort sort)
    : database_(database),
      sort_(sort),
      all_(prepare(database, std::string(kSelect) + "ORDER BY e.seq")),
      of_kind_(prepare(database, std::string(kSelect) + "AND e.kind = ?2 ORDER BY e.seq")) {
  seek(INT64_MIN, {});
}

void ChainRows::seek(std::int64_t seq, const std::string& kind) {
  for (sqlite3_stmt* statement : {all_.get(), of_kind_.get()})
    if (statement != nullptr) sqlite3_reset(statement);
  current_ = kind.empty() ? all_.get() : of_kind_.get();
  if (current_ == nullptr) return;
  sqlite3_bind_int64(current_, 1, seq);
  if (!kind.empty()) sqlite3_bind_text(current_, 2, kind.data(), static_cast<int>(kind.size()), SQLITE_TRANSIENT);
}

Result<std::optional<ChainReader::Row>> ChainRows::next() {
  if (current_ == nullptr) return fails(sqlite_message(database_));
  const int code = sqlite3_step(current_);
  if (code == SQLITE_DONE) {
    sqlite3_reset(current_);
    current_ = nullptr;
    return std::nullopt;
  }
  if (code == SQLITE_TOOBIG)
    return tl::unexpected("an entry holds more than " + std::to_string(ChainReader::kMaxBody) + " bytes");
  if (code != SQLITE_ROW) return fails(sqlite_message(database_));

  ChainReader::Row row;
  row.entry.seq = sqlite3_column_int64(current_, 0);
  const auto row_fails = [&row](const std::string& what) {
    return tl::unexpected("entry " + std::to_string(row.entry.seq) + ": " + what);
  };
  static constexpr int kTypes[] = {SQLITE_INTEGER, SQLITE_TEXT, SQLITE_INTEGER, SQLITE_BLOB, SQLITE_BLOB};
  for (int column = 0; column < 5; ++column)
    if (sqlite3_column_type(current_, column) != kTypes[column])
      return row_fails("its row has values of other types than the table's");
  row.entry.kind = column_bytes(current_, 1);
  row.entry.t_ns = sqlite3_column_int64(current_, 2);
  if (sort_ == ChainSort::run && !is_on_clock(row.entry.t_ns)) return row_fails(clock_fault(row.entry.t_ns));
  row.entry.body = column_bytes(current_, 3);
  if (sqlite3_errcode(database_) == SQLITE_NOMEM) return row_fails("out of memory");
  if (row.entry.body.size() > static_cast<std::size_t>(ChainReader::kMaxBody))
    return row_fails("more than " + std::to_string(ChainReader::kMaxBody) + " bytes");
  const std::string_view head = column_bytes(current_, 4);
  if (head.size() != row.head.size())
    return row_fails("its head has " + std::to_string(head.size()) + " bytes, expected 32");
  std::copy(head.begin(), head.end(), row.head.begin());
  if (sqlite3_column_type(current_, 5) != SQLITE_NULL) row.note = column_bytes(current_, 5);
  return std::optional(std::move(row));
}

}  // namespace dwell::record
