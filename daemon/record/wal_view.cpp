#include "daemon/record/wal_view.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <bitset>
#include <cerrno>
#include <cstring>
#include <vector>

namespace dwell::record {
namespace {

constexpr std::size_t kHeader = 32;       // bytes of the log's header
constexpr std::size_t kFrameHeader = 24;  // bytes before each page
constexpr std::uint32_t kMagic = 0x377f0682;

std::uint32_t big_endian(const unsigned char* bytes) {
  return std::uint32_t{bytes[0]} << 24 | std::uint32_t{bytes[1]} << 16 | std::uint32_t{bytes[2]} << 8 | bytes[3];
}

std::uint32_t little_endian(const unsigned char* bytes) {
  return std::uint32_t{bytes[3]} << 24 | std::uint32_t{bytes[2]} << 16 | std::uint32_t{bytes[1]} << 8 | bytes[0];
}

using Sums = std::array<std::uint32_t, 2>;

// Two words a step: s0 += x0 + s1, s1 += x1 + s0, modulo 2^32.
void add(Sums& sums, const unsigned char* bytes, std::size_t size, bool big) {
  for (std::size_t i = 0; i < size; i += 8) {
    sums[0] += (big ? big_endian(bytes + i) : little_endian(bytes + i)) + sums[1];
    sums[1] += (big ? big_endian(bytes + i + 4) : little_endian(bytes + i + 4)) + sums[0];
  }
}

// Inverse of an odd number, modulo 2^32. Each step doubles the number of right bits.
std::uint32_t inverse(std::uint32_t odd) {
  std::uint32_t x = odd;
  for (int i = 0; i < 4; ++i) x *= 2 - odd * x;
  return x;
}

// Do the sums differ by `error` because somebody changed one word of the data, or one bit of the sums? The sums are
// linear: a change d of a word in the last pair adds (d, d) or (0, d), and every further pair takes (a, b) to (a + b, a
// + 2b). Chance gives such an error once in a million.
bool one_word_explains(const Sums& stored, const Sums& computed, std::size_t pairs) {
  const std::bitset<64> bits(std::uint64_t{stored[0] ^ computed[0]} << 32 | (stored[1] ^ computed[1]));
  if (bits.count() == 1) return true;
  const Sums error{stored[0] - computed[0], stored[1] - computed[1]};
  Sums first{1, 1}, second{0, 1};
  for (std::size_t pair = 0; pair < pairs; ++pair) {
    for (Sums* effect : {&first, &second}) {
      const std::size_t odd = (*effect)[0] % 2 == 1 ? 0 : 1;  // one of the two always is
      const std::uint32_t change = error[odd] * inverse((*effect)[odd]);
      if ((*effect)[0] * change == error[0] && (*effect)[1] * change == error[1]) return true;
      const std::uint32_t a = (*effect)[0] + (*effect)[1];
      *effect = {a, a + (*effect)[1]};
    }
  }
  return false;
}

// Whether all bytes have come. Short: the file ends there.
bool read_at(int file, std::uint64_t offset, unsigned char* to, std::size_t size, bool& failed) {
  while (size > 0) {
    const ssize_t got = ::pread(file, to, size, static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) continue;
    failed = failed || got < 0;
    if (got <= 0) return false;
    to += got;
    offset += static_cast<std::uint64_t>(got);
    size -= static_cast<std::size_t>(got);
  }
  return true;
}

struct Frame {
  std::uint32_t page = 0, pages = 0;  // pages: of the database, where this frame commits; else 0
  bool salted = false;                // belongs to this log
  bool holds = false;                 // and its sums are right
  Sums stored{}, computed{};
};

// Reads frame after frame of one log.
class Frames {
 public:
  Frames(int file, const unsigned char* header, std::uint32_t page_size)
      : file_(file), bytes_(kFrameHeader + page_size), sums_{big_endian(header + 24), big_endian(header + 28)} {
    std::copy(header + 16, header + 24, salt_.begin());
    big_ = (big_endian(header) & 1u) != 0;
  }

  // false: the log ends before the next frame does.
  bool next(Frame& frame) {
    at_ = next_;
    if (!read_at(file_, at_, bytes_.data(), bytes_.size(), failed_)) return false;
    next_ = at_ + bytes_.size();
    const unsigned char* header = bytes_.data();
    frame.page = big_endian(header);
    frame.pages = big_endian(header + 4);
    frame.salted = std::equal(salt_.begin(), salt_.end(), header + 8);
    frame.stored = {big_endian(header + 16), big_endian(header + 20)};
    add(sums_, header, 8, big_);
    add(sums_, header + kFrameHeader, bytes_.size() - kFrameHeader, big_);
    frame.computed = sums_;
    frame.holds = frame.salted && frame.page != 0 && frame.stored == frame.computed;
    return true;
  }

  [[nodiscard]] std::uint64_t page_at() const { return at_ + kFrameHeader; }
  [[nodiscard]] std::size_t pairs() const { return (bytes_.size() - kFrameHeader) / 8 + 1; }
  [[nodiscard]] bool failed() const { return failed_; }

 private:
  int file_;
  bool big_ = false, failed_ = false;
  std::vector<unsigned char> bytes_;
  std::array<unsigned char, 8> salt_{};
  Sums sums_;
  std::uint64_t at_ = kHeader, next_ = kHeader;
};

// `bad` is the first invalid frame. Each commit is synchronized before the next begins. So a crash damages only the
// last transaction, and whole sectors of it.
bool altered_by_hand(Frames& frames, const Frame& bad) {
  if (!bad.salted && bad.stored == bad.computed) return true;
  if (bad.salted && one_word_explains(bad.stored, bad.computed, frames.pairs())) return true;
  bool committed = bad.salted && bad.pages != 0;
  Frame frame;
  while (frames.next(frame)) {
    if (!frame.salted) continue;
    if (committed) return true;  // another transaction after a damaged one
    committed = frame.pages != 0;
  }
  return false;
}

}  // namespace

Result<WalView> WalView::read(int file) {
  WalView view;
  bool failed = false;
  std::array<unsigned char, kHeader> header{};
  const bool complete = read_at(file, 0, header.data(), header.size(), failed);
  if (failed) return tl::unexpected("the -wal cannot be read: " + std::string(std::strerror(errno)));
  if (!complete || std::all_of(header.begin(), header.end(), [](unsigned char byte) { return byte == 0; })) return view;

  const std::uint32_t magic = big_endian(header.data());
  Sums sums{};
  add(sums, header.data(), 24, (magic & 1u) != 0);
  view.page_size_ = big_endian(header.data() + 8);
  const bool size_of_page =
      view.page_size_ >= 512 && view.page_size_ <= 65536 && (view.page_size_ & (view.page_size_ - 1)) == 0;
  if ((magic & ~1u) != kMagic || !size_of_page || sums[0] != big_endian(header.data() + 24) ||
      sums[1] != big_endian(header.data() + 28)) {
    view.altered_ = "the header of the -wal is damaged";
    return view;
  }

  Frames frames(file, header.data(), view.page_size_);
  std::vector<std::pair<std::uint32_t, std::uint64_t>> pending;
  Frame frame;
  for (std::uint64_t count = 1; frames.next(frame); ++count) {
    if (!frame.holds) {
      if (altered_by_hand(frames, frame)) view.altered_ = "frame " + std::to_string(count) + " of the -wal was altered";
      break;
    }
    if (count > kMaxFrames) return tl::unexpected("the -wal has more frames than " + std::to_string(kMaxFrames));
    pending.emplace_back(frame.page, frames.page_at());
    if (frame.pages == 0) continue;
    for (const auto& [page, offset] : pending) view.offsets_[page] = offset;
    pending.clear();
    view.pages_ = frame.pages;
  }
  if (frames.failed()) return tl::unexpected("the -wal cannot be read: " + std::string(std::strerror(errno)));
  return view;
}

std::uint64_t WalView::offset_of(std::uint32_t page) const {
  const auto found = offsets_.find(page);
  return found == offsets_.end() ? 0 : found->second;
}

}  // namespace dwell::record
