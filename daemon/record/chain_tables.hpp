// The two tables of a chain file, for its readers and writers. docs/run-file.md, "The container".
#pragma once

#include <optional>
#include <string>

#include "daemon/record/chain_file.hpp"
#include "daemon/record/sqlite.hpp"

namespace dwell::record {

inline constexpr const char* kEntryTable =
    "CREATE TABLE entry (seq INTEGER PRIMARY KEY, kind TEXT NOT NULL, t_ns INTEGER NOT NULL, body BLOB NOT NULL, head "
    "BLOB NOT NULL) STRICT";
inline constexpr const char* kNoteTable = "CREATE TABLE note (seq INTEGER PRIMARY KEY, text TEXT NOT NULL) STRICT";
inline constexpr int kFormatVersion = 2;  // user_version

// Checks that the database is a chain file of this sort, with these two tables and nothing else. Fails with what it
// found instead.
[[nodiscard]] Result<void> check_tables(sqlite3* database, ChainSort sort);

// A note as the one after it names it. Of the first note: 0, and 32 zero bytes.
struct NoteLink {
  std::int64_t seq = 0;  // the entry that it is on
  Digest hash{};         // note_hash() of its text
};

// The text that the note on an entry signs, and its lines up to those of the note before. docs/run-file.md, "The
// notes".
[[nodiscard]] std::string note_front(const std::string& origin, std::int64_t seq, const Digest& head,
                                     std::int64_t t_ns);
[[nodiscard]] std::string note_text(const std::string& origin, std::int64_t seq, const Digest& head, std::int64_t t_ns,
                                    const NoteLink& before);

// Rows in the order of seq. Borrows the database. Bound to one thread.
class ChainRows {
 public:
  ChainRows(sqlite3* database, ChainSort sort);
  // As ChainReader's.
  void seek(std::int64_t seq, const std::string& kind);
  // Fails with the reason, without the path. The t_ns of a run's entries is within the bounds of instants.hpp.
  [[nodiscard]] Result<std::optional<ChainReader::Row>> next();

 private:
  sqlite3* database_;
  ChainSort sort_;
  Statement all_, of_kind_;
  sqlite3_stmt* current_ = nullptr;
};

}  // namespace dwell::record
