#include "daemon/record/block_count.hpp"

#include <zstd.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "daemon/record/block.hpp"

namespace dwell::record {
namespace {

constexpr std::uint32_t kVersion = 1;
constexpr std::size_t kFront = 8;  // version, number of records

tl::unexpected<Failure> block_fails(const std::string& reason) { return fails("block: " + reason); }

std::uint32_t u32(std::string_view bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 4; i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
  return value;
}

}  // namespace

struct BlockCount::Impl {
  std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context{ZSTD_createDCtx(), ZSTD_freeDCtx};
  std::vector<char> kinds = std::vector<char>(ZSTD_DStreamOutSize());
};

BlockCount::BlockCount() : impl_(std::make_unique<Impl>()) {}
BlockCount::BlockCount(BlockCount&&) noexcept = default;
BlockCount& BlockCount::operator=(BlockCount&&) noexcept = default;
BlockCount::~BlockCount() = default;

Result<std::uint64_t> BlockCount::samples(std::string_view block) {
  if (block.size() < kFront) return block_fails("it ends before its records");
  if (u32(block, 0) != kVersion) return block_fails("version " + std::to_string(u32(block, 0)) + ", expected 1");
  const std::size_t records = u32(block, 4);
  if (records > kMaxBlockRecords) return block_fails(std::to_string(records) + " records are more than a block holds");
  const std::string_view frame = block.substr(kFront);
  if (ZSTD_getFrameContentSize(frame.data(), frame.size()) != kPlanes * records)
    return block_fails("its size is not that of " + std::to_string(records) + " records");
  if (!impl_->context) return block_fails("out of memory");

  ZSTD_DCtx_reset(impl_->context.get(), ZSTD_reset_session_only);
  // The frame states the size of its window, which is never larger than its content.
  ZSTD_DCtx_setParameter(impl_->context.get(), ZSTD_d_windowLogMax, 27);
  ZSTD_inBuffer in{frame.data(), frame.size(), 0};
  std::uint64_t count = 0;
  for (std::size_t left = records; left > 0;) {
    ZSTD_outBuffer out{impl_->kinds.data(), std::min(left, impl_->kinds.size()), 0};
    const std::size_t code = ZSTD_decompressStream(impl_->context.get(), &out, &in);
    if (ZSTD_isError(code) != 0) return block_fails(ZSTD_getErrorName(code));
    if (out.pos == 0 && in.pos == in.size) return block_fails("it ends before its records");
    count += static_cast<std::uint64_t>(
        std::count(impl_->kinds.data(), impl_->kinds.data() + out.pos, static_cast<char>(Kind::sample)));
    left -= out.pos;
  }
  return count;
}

}  // namespace dwell::record
