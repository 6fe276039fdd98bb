// Reserves room on the disk, with a file of that size in the recording directory. The room is released while a run
// ends, so that its last entries fit on a full disk.
#pragma once

#include <cstdint>
#include <string>

#include "daemon/record/result.hpp"

namespace dwell::record {

// Name of the reserve's file in the recording directory.
inline constexpr const char* kReserveName = "reserve";

// Bound to one thread.
class DiskReserve {
 public:
  // Needed: the last batch of a run, one second (3 MB for 64 channels at 10 kHz); and 4 MB and a batch for what moves
  // from the -wal into the file as it is closed. Twice that, and room for the ledger.
  static constexpr std::int64_t kBytes = 32'000'000;

  explicit DiskReserve(std::string path, std::int64_t bytes = kBytes) : path_(std::move(path)), bytes_(bytes) {}

  [[nodiscard]] bool is_held() const;
  // Takes the room if it is not held already. Fails with "PATH: disk full" or "PATH: reason"; then nothing is held.
  [[nodiscard]] Result<void> hold();
  // Releases the room; does nothing if none is held.
  void release() noexcept;

 private:
  std::string path_;
  std::int64_t bytes_;
};

// Bytes that a user without privileges may still write where `path` is. Fails with "PATH: reason".
[[nodiscard]] Result<std::int64_t> free_bytes(const std::string& path);

}  // namespace dwell::record
