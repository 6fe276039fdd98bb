// Writes a file as a whole or not at all: it has another name until it is complete.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "daemon/record/regular_file.hpp"
#include "daemon/record/result.hpp"

namespace dwell::handon {

// Where a file is written. Without `overwrite` nothing may be there yet; with it, only a regular file may.
struct Target {
  // Not explicit: most callers mean "a new file of this name".
  Target(std::string at, bool may_overwrite = false) : path(std::move(at)), overwrite(may_overwrite) {}
  std::string path;
  bool overwrite = false;
};

// Whether a file may be written there, else "PATH: found, expected". Never in place of a run file, a ledger, a private
// key or what belongs to one, neither by its name nor by its content; never in place of a link, a device or a pipe. In
// a recording directory never at a name that the service gives its own files, even if no file is there.
[[nodiscard]] record::Result<void> may_write(const Target& target);
// The same for a new run file: it may have the name of a run, and no file may be there yet.
[[nodiscard]] record::Result<void> may_make_run(const std::string& path);

// Bound to one thread. keep() returns the first failure; everything written after that is dropped.
class OutputFile {
 public:
  // Fails as may_write() does, and while another OutputFile of that name exists, in this program or another. An
  // existing file of that name stays until keep().
  [[nodiscard]] static record::Result<OutputFile> create(const Target& target);
  OutputFile(OutputFile&& other) noexcept;
  OutputFile& operator=(OutputFile&&) = delete;
  ~OutputFile();  // removes the file unless keep() succeeded

  // Appends; buffered.
  void write(std::string_view bytes);
  // Writes at that place of the file; not buffered.
  void write_at(std::int64_t place, std::string_view bytes);
  // Gives the file its name, or fails with "PATH: why".
  [[nodiscard]] record::Result<void> keep();

  // The file's name while it is written.
  [[nodiscard]] const std::string& part() const noexcept { return part_; }

 private:
  OutputFile(Target target, std::string part, record::OpenFile file);
  void flush();

  std::string path_, part_, buffer_, error_;
  bool overwrite_ = false;
  std::int64_t end_ = 0;  // bytes of the file so far; the buffer goes there
  record::OpenFile file_;
};

}  // namespace dwell::handon
