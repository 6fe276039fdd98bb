#include "daemon/record/block_cutter.hpp"

#include <algorithm>
#include <utility>

#include "daemon/record/block.hpp"

namespace dwell::record {

static_assert(BlockCutter::kBlockRecords <= kMaxBlockRecords);

bool BlockCutter::is_due_before(const Record& next) const noexcept {
  if (records_.empty()) return false;
  // A run begins with a block of its own.
  if (is_edge(next, RunEdge::armed)) return true;
  return records_.size() >= kBlockRecords || next.t_ns - records_.front().t_ns >= kBlock_ns;
}

void BlockCutter::add(const Record& record) {
  records_.push_back(record);
  ++number_;
}

Block BlockCutter::take() {
  Block block;
  block.records = records_.size();
  block.first = number_ + 1 - block.records;
  block.samples = static_cast<std::uint64_t>(
      std::count_if(records_.begin(), records_.end(), [](const Record& r) { return r.kind == Kind::sample; }));
  block.first_t_ns = records_.front().t_ns;
  block.last_t_ns = records_.back().t_ns;
  for (std::size_t i = 0; i < records_.size() && block.told.size() < kMostTold; ++i)
    if (records_[i].kind == Kind::loss || records_[i].kind == Kind::fault)
      block.told.emplace_back(block.first + i, records_[i]);
  block.body = encode_block(records_);
  records_.clear();
  return block;
}

void KeptBlocks::pipeline_born(std::uint64_t number) {
  if (newest_birth_ != 0) drop_before(newest_birth_);
  newest_birth_ = number;
}

void KeptBlocks::add(Block block) {
  bytes_ += block.body.size();
  blocks_.push_back(std::move(block));
  while (bytes_ > kBytes && blocks_.size() > 1) drop_before(blocks_[1].first);
}

std::deque<Block> KeptBlocks::take_from(std::uint64_t first) {
  drop_before(first);
  std::deque<Block> taken;
  if (!blocks_.empty() && blocks_.front().first == first) taken = std::move(blocks_);
  clear();
  return taken;
}

void KeptBlocks::clear() noexcept {
  blocks_.clear();
  bytes_ = 0;
  newest_birth_ = 0;
}

void KeptBlocks::drop_before(std::uint64_t number) {
  while (!blocks_.empty() && blocks_.front().first < number) {
    bytes_ -= blocks_.front().body.size();
    blocks_.pop_front();
  }
}

}  // namespace dwell::record
