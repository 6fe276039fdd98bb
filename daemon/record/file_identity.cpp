#include "daemon/record/file_identity.hpp"

#include <sys/stat.h>

namespace dwell::record {

FileIdentity identity_of(const std::string& path) {
  FileIdentity identity{};
  std::size_t at = 0;
  for (const char* part : {"", "-wal"}) {
    struct stat status {};
    const bool there = ::stat((path + part).c_str(), &status) == 0;
    identity[at++] = there ? status.st_size : 0;
    identity[at++] = there ? status.st_mtim.tv_sec : 0;
    identity[at++] = there ? status.st_mtim.tv_nsec : 0;
  }
  return identity;
}

}  // namespace dwell::record
