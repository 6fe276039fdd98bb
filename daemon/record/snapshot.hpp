// Reads a database through SQLite in the state at opening, without altering a byte: no lock, no -shm, no recovery, no
// checkpoint. Works on a read-only file system, and while a writer goes on.
//
// A shared flock on the -wal asks the writer not to make a checkpoint. The writer makes one all the same at the end of
// the run, or if the log has ChainReader::kMaxWal bytes. Then unchanged() returns false.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "daemon/record/result.hpp"

struct sqlite3;

namespace dwell::record {

// A writer merged the -wal into the file during reading. front: "PATH: ".
[[nodiscard]] inline Failure read_again(const std::string& front = {}) {
  return {front + "written to while it was read: read it again", Cause::read_again};
}

// How often a file is read that a writer alters meanwhile. A writer does that at the end of a run, and where its -wal
// has grown too large: twice in a row takes a run that ends just then.
inline constexpr int kReadTries = 5;
// Calls `read` anew while it fails because a writer altered the file meanwhile; kReadTries times at most.
template <class Read>
[[nodiscard]] auto read_until_whole(const Read& read) {
  for (int tries = 1;; ++tries) {
    auto result = read();
    if (result || result.error().cause() != Cause::read_again || tries == kReadTries) return result;
  }
}

// Bound to one thread.
class Snapshot {
 public:
  // Fails with "PATH: reason", also if the file is no SQLite database. Waits for a running checkpoint. stop: asked
  // before each page is read, from now on; once it says true, all reading fails. Empty: never.
  [[nodiscard]] static Result<Snapshot> open(const std::string& path, const std::function<bool()>& stop = {});
  Snapshot(Snapshot&&) noexcept;
  Snapshot& operator=(Snapshot&&) noexcept;
  ~Snapshot();

  [[nodiscard]] sqlite3* database() const noexcept;
  [[nodiscard]] const std::string& path() const noexcept;
  // Whether everything read so far is of one state. Cost: three system calls.
  [[nodiscard]] bool unchanged() const noexcept;
  // Whether `stop` has said so.
  [[nodiscard]] bool stopped() const noexcept;
  // Damage of the -wal that no crash causes, or a -journal beside the file; empty: none.
  [[nodiscard]] const std::string& altered() const noexcept;

 private:
  struct Impl;
  explicit Snapshot(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace dwell::record
