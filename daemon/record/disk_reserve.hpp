// Room on the disk that is given free when the disk is full, so that the last entries of a run can still be written: a
// file of its size in the recording directory.
#pragma once

#include <cstdint>
#include <string>

#include "daemon/record/keys.hpp"

namespace dwell::record {

// Bound to one thread.
class DiskReserve {
 public:
  // The last batch of a run (3 MB at 64 channels of 10 kHz, whose second it holds), and what moves from its -wal into
  // the file as it is closed: 4 MB and a batch. Twice that, and room for the ledger.
  static constexpr std::int64_t kBytes = 32'000'000;

  explicit DiskReserve(std::string path, std::int64_t bytes = kBytes) : path_(std::move(path)), bytes_(bytes) {}

  // Takes the room, unless it is held already; fails with "disk full" or another reason, and holds nothing then.
  [[nodiscard]] Result<void> hold();
  // Gives it free; harmless where nothing is held.
  void release() noexcept;

 private:
  std::string path_;
  std::int64_t bytes_;
};

// Bytes that a user without privileges may still write where `path` is; fails with the reason.
[[nodiscard]] Result<std::int64_t> free_bytes(const std::string& path);

}  // namespace dwell::record
