// Cuts the stream into encoded blocks of about a second, and keeps the blocks that a later run may reach back to.
#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "core/stream/record.hpp"

namespace dwell::record {

// An encoded stretch of the stream.
struct Block {
  std::uint64_t first = 0;  // number of its first record, from 1 on, since the service began
  std::uint64_t records = 0;
  std::uint64_t samples = 0;
  std::int64_t first_t_ns = 0, last_t_ns = 0;
  std::string body;
  std::vector<std::pair<std::uint64_t, Record>> told;  // losses and faults, at most kMostTold, by number of record
};
// Most losses and faults of a block that become events of a run. They are needed of blocks kept from before the run. A
// device has a few faults a second; more than these are in the stream alone.
inline constexpr std::size_t kMostTold = 1000;

// Bound to one thread. Memory: the records of one block, at most 32 MiB; take() needs up to 70 MiB more while it
// encodes.
class BlockCutter {
 public:
  // Doubled, a power failure loses more. Halved, there are more commits, and a block compresses less.
  static constexpr std::int64_t kBlock_ns = 1'000'000'000;
  static constexpr std::size_t kBlockRecords = 1u << 20;

  // Whether `next` needs a new block: then call take() before adding it.
  [[nodiscard]] bool is_due_before(const Record& next) const noexcept;
  void add(const Record& record);
  [[nodiscard]] bool empty() const noexcept { return records_.empty(); }
  // The block so far, which must not be empty; a new one begins.
  [[nodiscard]] Block take();
  // Forgets the block so far.
  void clear() noexcept { records_.clear(); }
  // Counts `records` missing ones, as if they had come. The block must be empty.
  void skip(std::uint64_t records) noexcept { number_ += records; }
  // Of the record added last.
  [[nodiscard]] std::uint64_t number() const noexcept { return number_; }

 private:
  std::vector<Record> records_;
  std::uint64_t number_ = 0;
};

// The blocks since the start of the elder of the two pipelines that wait for a drive (stream_sink.hpp). A run begins
// with them. Bound to one thread. Memory: two spans of the stream, encoded; at most kBytes.
class KeptBlocks {
 public:
  // Two spans of 10 s of 64 channels at 10 kHz are 77 MB at 6 bytes a sample. Beyond this the oldest block is dropped,
  // and a run that would reach back to it is not recorded. Doubled, the service needs more memory; halved, a slow drive
  // on a large rig is not recorded.
  static constexpr std::size_t kBytes = 100'000'000;

  // The next block begins with the birth of a pipeline. Drops the blocks before the previous birth.
  void pipeline_born(std::uint64_t number);
  void add(Block block);
  // Hands over everything from record `first` on, and keeps nothing. Empty: `first` is not there.
  [[nodiscard]] std::deque<Block> take_from(std::uint64_t first);
  void clear() noexcept;
  [[nodiscard]] std::size_t bytes() const noexcept { return bytes_; }

 private:
  void drop_before(std::uint64_t number);

  std::deque<Block> blocks_;
  std::size_t bytes_ = 0;
  std::uint64_t newest_birth_ = 0;
};

}  // namespace dwell::record
