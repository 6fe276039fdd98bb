// Ensures that one service at a time records into a directory; readers are not kept out. The lock ends with the
// process, however that ends.
#pragma once

#include <string>

#include "daemon/record/result.hpp"

namespace dwell::record {

// Bound to one thread.
class DirectoryLock {
 public:
  DirectoryLock() = default;
  ~DirectoryLock();
  DirectoryLock(const DirectoryLock&) = delete;
  DirectoryLock& operator=(const DirectoryLock&) = delete;

  // Does not wait. Does nothing if this object holds a lock already. Fails with "DIRECTORY: why".
  [[nodiscard]] Result<void> take(const std::string& directory);

 private:
  int file_ = -1;
};

}  // namespace dwell::record
