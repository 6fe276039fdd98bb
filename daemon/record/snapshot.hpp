// A database as it was when it was opened, read through SQLite without altering a byte: no lock, no -shm, no recovery,
// no checkpoint, also from a read-only place, also while its writer goes on.
//
// A shared flock on the -wal asks the writer to leave log and database as they are: it makes no checkpoint while it
// cannot have that lock for itself. Where it must (a log of ChainReader::kMaxWal bytes, the end of the run),
// unchanged() tells.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "daemon/record/keys.hpp"

struct sqlite3;

namespace dwell::record {

// How the message begins when a writer had to break a snapshot. Reading again helps.
inline constexpr const char* kReadAgain = "written to while it was read: read it again";

// Bound to one thread.
class Snapshot {
 public:
  // Fails with "PATH: reason", also where it is no SQLite database. Waits for a checkpoint under way.
  [[nodiscard]] static Result<Snapshot> open(const std::string& path);
  Snapshot(Snapshot&&) noexcept;
  Snapshot& operator=(Snapshot&&) noexcept;
  ~Snapshot();

  [[nodiscard]] sqlite3* database() const noexcept;
  [[nodiscard]] const std::string& path() const noexcept;
  // Whether all that was read so far is of one state. Cost: three system calls.
  [[nodiscard]] bool unchanged() const noexcept;
  // What no crash leaves behind in the -wal; empty: nothing.
  [[nodiscard]] const std::string& altered() const noexcept;

 private:
  struct Impl;
  explicit Snapshot(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace dwell::record
