// Counts the samples of a block in a hundredth of the time of decode_block(): the kinds of the records are the block's
// first plane. docs/run-file.md, "Blocks".
#pragma once

#include <cstdint>
#include <memory>
#include <string_view>

#include "daemon/record/result.hpp"

namespace dwell::record {

// Bound to one thread. Holds some 200 kB.
class BlockCount {
 public:
  BlockCount();
  BlockCount(BlockCount&&) noexcept;
  BlockCount& operator=(BlockCount&&) noexcept;
  ~BlockCount();

  // Fails if the beginning of the block, up to the last kind, is malformed.
  [[nodiscard]] Result<std::uint64_t> samples(std::string_view block);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace dwell::record
