// Owners of SQLite's objects, and its errors as one line. For the sources of this folder.
#pragma once

#include <sqlite3.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace dwell::record {

struct CloseDatabase {
  void operator()(sqlite3* database) const { sqlite3_close_v2(database); }
};
using Database = std::unique_ptr<sqlite3, CloseDatabase>;

struct FinalizeStatement {
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using Statement = std::unique_ptr<sqlite3_stmt, FinalizeStatement>;

// "PATH: reason" of the call on `database` that has just failed. A full disk reads "disk full" whichever call met it.
[[nodiscard]] std::string sqlite_error(sqlite3* database, const std::string& path);

// SQLite's message for the call that has just failed, passed through one_line(): it may repeat bytes of the file.
[[nodiscard]] std::string sqlite_message(sqlite3* database);

// For a message: at most 200 bytes of `text`, control characters as "?".
[[nodiscard]] std::string one_line(std::string_view text);

// nullptr: failed.
[[nodiscard]] Statement prepare(sqlite3* database, std::string_view sql);

// Runs statements that yield nothing; false: failed.
[[nodiscard]] bool execute(sqlite3* database, const char* sql);

// Runs step(database). While another process has the file locked, asks `busy` whether to try again; empty: gives up at
// once. false: failed.
[[nodiscard]] bool while_busy(sqlite3* database, const std::function<bool(int tries)>& busy, bool (*step)(sqlite3*));

// The first column of the first row. Empty: failed, or there is none.
[[nodiscard]] std::string first_text(sqlite3* database, const char* sql);

// A column's bytes; valid until the statement goes on.
[[nodiscard]] std::string_view column_bytes(sqlite3_stmt* statement, int column);

}  // namespace dwell::record
