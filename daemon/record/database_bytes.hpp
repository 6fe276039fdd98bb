// Reads a database byte by byte, as a download sends it.
//
// SQLite's locks are those of fcntl(2): a process loses all that it has on a file once it closes any descriptor of it.
// So the file is opened and closed by SQLite itself, which puts off closing while one of its connections has a lock. No
// other descriptor of a database may be closed in a process that may also write it (regular_file.hpp).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "daemon/record/result.hpp"

struct sqlite3_file;

namespace dwell::record {

// One thread at a time. Takes no lock: the bytes may change meanwhile (file_identity.hpp).
class DatabaseBytes {
 public:
  // Refuses a link. Fails with "PATH: reason".
  [[nodiscard]] static Result<DatabaseBytes> open(const std::string& path);

  // As it was when it was opened.
  [[nodiscard]] std::uint64_t size() const noexcept { return size_; }
  // false: there are fewer, or the disk failed.
  [[nodiscard]] bool read(std::uint64_t offset, char* to, std::size_t bytes) const noexcept;

 private:
  struct Close {
    void operator()(sqlite3_file* file) const noexcept;
  };
  struct FreeName {
    void operator()(const char* name) const noexcept;
  };
  DatabaseBytes() = default;

  std::unique_ptr<const char, FreeName> name_;  // SQLite keeps the pointer: it goes after the file
  std::unique_ptr<sqlite3_file, Close> file_;
  std::uint64_t size_ = 0;
};

}  // namespace dwell::record
