// A file system for SQLite that shows a database and its -wal as one read-only file. A page comes from the log if a
// committed frame holds it, otherwise from the database. Nothing is locked, created or altered.
#pragma once

#include <sqlite3.h>

#include <functional>
#include <string>

#include "daemon/record/wal_view.hpp"

namespace dwell::record {

// Registered with SQLite while it exists; must outlive the connection that uses it. Bound to one thread.
class OverlayVfs {
 public:
  // wal_file: an open log, owned by the caller; -1: there is none. It is read when SQLite opens the database. stop:
  // asked before each read; once it says true, it is asked no more and every read fails. Empty: never.
  explicit OverlayVfs(int wal_file, std::function<bool()> stop = {});
  OverlayVfs(const OverlayVfs&) = delete;
  OverlayVfs& operator=(const OverlayVfs&) = delete;
  ~OverlayVfs();

  [[nodiscard]] const char* name() const noexcept { return name_.c_str(); }
  // Why the database could not be opened; empty: SQLite states the reason.
  [[nodiscard]] const std::string& error() const noexcept { return error_; }
  // Whether `stop` has said so.
  [[nodiscard]] bool stopped() const noexcept { return stopped_; }
  // Damage of the log that no crash causes, or that the log belongs to another database; empty: neither.
  [[nodiscard]] const std::string& altered() const noexcept { return altered_; }

 private:
  struct File;
  static int open(sqlite3_vfs* vfs, const char* path, sqlite3_file* file, int flags, int* out_flags);
  static int read(sqlite3_file* file, void* to, int size, sqlite3_int64 offset);
  static int size(sqlite3_file* file, sqlite3_int64* bytes);
  static const sqlite3_io_methods& methods();
  int take_log(sqlite3_file* database);

  sqlite3_vfs* parent_;
  sqlite3_vfs vfs_;
  int wal_file_;
  std::function<bool()> stop_;
  bool stopped_ = false;
  std::string name_, error_, altered_;
  WalView wal_;
};

}  // namespace dwell::record
