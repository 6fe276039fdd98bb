// The log (-wal) beside a chain's database: when its pages go into the database, and what waits for the disk.
//
// SQLite alone would wait for the disk twice or more at each of these steps, and the ledger's next entries would wait
// as long. So SQLite is told not to wait there. The log waits itself, no more often than a loss of power asks for.
#pragma once

#include <sqlite3.h>

#include <string>

#include "daemon/record/regular_file.hpp"
#include "daemon/record/result.hpp"

namespace dwell::record {

// Of one connection of open_chain_database(). Bound to the writer's thread.
class ChainLog {
 public:
  // path: the database's present name; must outlive this.
  explicit ChainLog(const std::string& path) : path_(path) {}
  ChainLog(const ChainLog&) = delete;
  ChainLog& operator=(const ChainLog&) = delete;

  // The connection; it must be closed before this goes.
  void attach(sqlite3* database);

  // A transaction has failed: its frames may follow the log's end, until the log is moved into the database.
  void mark_stale() noexcept { stale_ = true; }
  // Right after a transaction, before it counts: waits for the disk where SQLite has not. false: broken() says why.
  [[nodiscard]] bool synchronize();
  // After a transaction that counts: moves the log into the database if it is long enough, as merge() does.
  void checkpoint();
  // Moves the log into the database unless somebody reads. If the pages cannot be copied, that only costs room: the
  // committed entries are in the log, and the next call tries again.
  void merge();
  // Makes it one file without -wal; fails with the reason. Nothing may be written afterwards.
  [[nodiscard]] Result<void> leave();

  // Why nothing more may be written; empty: it may.
  [[nodiscard]] const std::string& broken() const noexcept { return broken_; }

 private:
  [[nodiscard]] bool move(int mode);
  [[nodiscard]] Result<void> synchronize_database();
  void wait_again();

  const std::string& path_;
  sqlite3* database_ = nullptr;
  int frames_ = 0;  // after the last commit
  OpenFile file_;   // for its flock: Snapshot
  bool stale_ = false;
  bool new_ = false;  // it is empty, and SQLite does not wait for the disk: the next commit does
  std::string broken_;
};

}  // namespace dwell::record
