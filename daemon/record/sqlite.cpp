#include "daemon/record/sqlite.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace dwell::record {

std::string sqlite_error(sqlite3* database, const std::string& path) {
  if (database == nullptr) return path + ": out of memory";
  const int code = sqlite3_errcode(database);
  const int of_system = sqlite3_system_errno(database);
  if (code == SQLITE_FULL || (code == SQLITE_IOERR && of_system == ENOSPC)) return path + ": disk full";
  if (code == SQLITE_BUSY) return path + ": another process has it open for writing";
  std::string text = path + ": " + sqlite_message(database);
  if ((code == SQLITE_IOERR || code == SQLITE_CANTOPEN) && of_system != 0)
    text += std::string(" (") + std::strerror(of_system) + ")";
  return text;
}

std::string sqlite_message(sqlite3* database) { return one_line(sqlite3_errmsg(database)); }

std::string one_line(std::string_view text) {
  std::string line(text.substr(0, 200));
  std::replace_if(
      line.begin(), line.end(), [](char c) { return (c >= 0 && c < ' ') || c == 0x7F; }, '?');
  return line;
}

Statement prepare(sqlite3* database, std::string_view sql) {
  sqlite3_stmt* statement = nullptr;
  sqlite3_prepare_v3(database, sql.data(), static_cast<int>(sql.size()), SQLITE_PREPARE_PERSISTENT, &statement,
                     nullptr);
  return Statement(statement);
}

bool execute(sqlite3* database, const char* sql) {
  return sqlite3_exec(database, sql, nullptr, nullptr, nullptr) == SQLITE_OK;
}

bool while_busy(sqlite3* database, const std::function<bool(int tries)>& busy, bool (*step)(sqlite3*)) {
  if (!busy) return step(database);
  std::function<bool(int tries)> asked = busy;
  sqlite3_busy_handler(
      database,
      [](void* own, int tries) { return (*static_cast<std::function<bool(int tries)>*>(own))(tries) ? 1 : 0; }, &asked);
  const bool done = step(database);
  // This call leaves the database's error as the step left it, so the caller can still ask for that.
  sqlite3_busy_handler(database, nullptr, nullptr);
  return done;
}

std::string first_text(sqlite3* database, const char* sql) {
  const Statement statement = prepare(database, sql);
  if (!statement || sqlite3_step(statement.get()) != SQLITE_ROW) return {};
  return std::string(column_bytes(statement.get(), 0));
}

std::string_view column_bytes(sqlite3_stmt* statement, int column) {
  // The pointer first: asking for it may convert the value, and so change its length.
  const char* bytes = sqlite3_column_type(statement, column) == SQLITE_BLOB
                          ? static_cast<const char*>(sqlite3_column_blob(statement, column))
                          : reinterpret_cast<const char*>(sqlite3_column_text(statement, column));
  if (bytes == nullptr) return {};
  return {bytes, static_cast<std::size_t>(sqlite3_column_bytes(statement, column))};
}

}  // namespace dwell::record
