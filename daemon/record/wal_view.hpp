// Reads a write-ahead log of SQLite ("-wal") without SQLite, which would write while it reads one. Finds the place of
// each page of the database. The format is SQLite's own, fileformat2.html, section 4.
#pragma once

#include <cstdint>
#include <string>
#include <unordered_map>

#include "daemon/record/result.hpp"

namespace dwell::record {

class WalView {
 public:
  // Frames of a log at most: bounds the memory that a hostile file can take, 80 MB.
  static constexpr std::uint64_t kMaxFrames = 1u << 21;

  // Reads all of an open file. Takes the frames that SQLite's recovery would: up to the last commit before the first
  // frame whose checksum or salt is wrong. Fails if the file cannot be read.
  [[nodiscard]] static Result<WalView> read(int file);

  // Where the page lies in the log; 0: not in it. Pages count from 1.
  [[nodiscard]] std::uint64_t offset_of(std::uint32_t page) const;
  [[nodiscard]] bool empty() const noexcept { return offsets_.empty(); }
  [[nodiscard]] std::uint32_t page_size() const noexcept { return page_size_; }
  // Pages of the database, with the log.
  [[nodiscard]] std::uint32_t pages() const noexcept { return pages_; }
  // Damage that no crash causes: bytes altered before the end of the log; empty: none. A loss of power can only damage
  // what was written since the last synchronized commit.
  [[nodiscard]] const std::string& altered() const noexcept { return altered_; }

 private:
  std::unordered_map<std::uint32_t, std::uint64_t> offsets_;
  std::string altered_;
  std::uint32_t page_size_ = 0;
  std::uint32_t pages_ = 0;
};

}  // namespace dwell::record
