// Opens files that others may have put there: those of the recording directory and of the command line. A named pipe
// or a device in place of a file would hold up whoever opens it, so it is refused with "PATH: is no regular file".
#pragma once

#include <fcntl.h>

#include <string>

#include "daemon/record/result.hpp"

namespace dwell::record {

// An open file, closed with its owner; or none.
class OpenFile {
 public:
  OpenFile() = default;
  explicit OpenFile(int number) noexcept : number_(number) {}
  OpenFile(OpenFile&& other) noexcept;
  OpenFile& operator=(OpenFile&& other) noexcept;
  ~OpenFile();

  explicit operator bool() const noexcept { return number_ >= 0; }
  // The descriptor; negative: none.
  [[nodiscard]] int get() const noexcept { return number_; }

 private:
  int number_ = -1;
};

// The system's text for an errno. A full disk or quota reads "disk full", as in the messages of sqlite_error(). This
// and the functions below: any thread; allocate.
[[nodiscard]] std::string system_text(int error);

// flags, mode: as of open(2). Never waits for another process. Truncates nothing but a regular file. Fails with
// "PATH: reason". Not for a database that this process may also write: closing the file would take away SQLite's locks
// on it (database_bytes.hpp).
[[nodiscard]] Result<OpenFile> open_regular(const std::string& path, int flags = O_RDONLY, mode_t mode = 0644);
// The same for reading; none if there is no such file.
[[nodiscard]] Result<OpenFile> open_regular_if_there(const std::string& path);

// Fails with "PATH: reason" if there is no regular file. For files that SQLite opens: it would wait for a named pipe. A
// link counts as the file that it leads to.
[[nodiscard]] Result<void> expect_regular(const std::string& path);

}  // namespace dwell::record
