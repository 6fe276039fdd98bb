// How many samples a block holds, in a hundredth of the time that decode_block() takes: the kinds of the records are
// the block's first plane. docs/run-file.md, "Blocks".
#pragma once

#include <cstdint>
#include <memory>
#include <string_view>

#include "daemon/record/keys.hpp"

namespace dwell::record {

// Bound to one thread. Keeps some 200 kB from one block to the next.
class BlockCount {
 public:
  BlockCount();
  BlockCount(BlockCount&&) noexcept;
  BlockCount& operator=(BlockCount&&) noexcept;
  ~BlockCount();

  // Fails where the front of the block, up to the last kind, is none that a writer writes.
  [[nodiscard]] Result<std::uint64_t> samples(std::string_view block);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace dwell::record
