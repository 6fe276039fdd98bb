// Writes a file as a whole or not at all: it has another name until it is complete.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "daemon/record/keys.hpp"

namespace dwell::handon {

// Bound to one thread. keep() returns the first failure; everything written after that is dropped.
class OutputFile {
 public:
  // An existing file of that name stays until keep().
  [[nodiscard]] static record::Result<OutputFile> create(const std::string& path);
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
  OutputFile(std::string path, std::string part, int fd);
  void flush();

  std::string path_, part_, buffer_, error_;
  std::int64_t end_ = 0;  // bytes of the file so far; the buffer goes there
  int fd_ = -1;
};

}  // namespace dwell::handon
