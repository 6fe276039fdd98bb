// Keeps other processes out of a recording directory. The lock ends with the process, however that ends.
#pragma once

#include <string>

#include "daemon/record/keys.hpp"

namespace dwell::record {

// Bound to one thread.
class DirectoryLock {
 public:
  DirectoryLock() = default;
  ~DirectoryLock();
  DirectoryLock(const DirectoryLock&) = delete;
  DirectoryLock& operator=(const DirectoryLock&) = delete;

  // Does nothing if it is held already. Fails with "DIRECTORY: why".
  [[nodiscard]] Result<void> take(const std::string& directory);

 private:
  int file_ = -1;
};

}  // namespace dwell::record
