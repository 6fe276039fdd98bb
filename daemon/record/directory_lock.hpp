// One process at a time works in a recording directory. However that process ends, the directory is free then.
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

  // Harmless where it is held already. Fails with "DIRECTORY: why".
  [[nodiscard]] Result<void> take(const std::string& directory);

 private:
  int file_ = -1;
};

}  // namespace dwell::record
