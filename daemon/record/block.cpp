#include "daemon/record/block.hpp"

#include <zstd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <memory>
#include <new>
#include <unordered_map>

namespace dwell::record {
namespace {

using Byte = std::uint8_t;

constexpr std::uint32_t kBlockVersion = 1;
constexpr std::size_t kPreamble = 8;  // version, number of records
// Level 1 yields up to 7 % more bytes and takes at least three quarters of the time. Level 9 takes three times as long
// and saves at most 1 %.
constexpr int kLevel = 3;

// RecordColumns, and the planes that each takes: one for each byte of its numbers, the lowest first.
struct Column {
  std::size_t plane;  // its first
  std::size_t bytes;
};
constexpr Column kKind{0, 1}, kFlags{1, 1}, kForm{2, 1}, kChannel{3, 2}, kHalf{5, 4}, kInstant{9, 8}, kDelay{17, 8},
    kValue{25, 8};

// How a value becomes 64 bits with small differences. Within a block a channel's form only gets wider.
enum class Form : Byte {
  integer = 0,  // a whole number within ± 2^53
  float32 = 1,  // exact in 32 bits of floating point: these bits
  float64 = 2,  // any: its bits
};
constexpr Byte kMostForm = 2;
constexpr double kMostInteger = 9007199254740992.0;

[[nodiscard]] bool same(double a, double b) noexcept {  // -0.0 and the payload of a NaN count
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

[[nodiscard]] double value_of(std::uint64_t bits, Form form) noexcept {
  switch (form) {
    case Form::integer:
      return static_cast<double>(static_cast<std::int64_t>(bits));
    case Form::float32:
      return static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits)));
    default:
      return std::bit_cast<double>(bits);
  }
}

[[nodiscard]] std::uint64_t bits_of(double value, Form form) noexcept {
  switch (form) {
    case Form::integer:
      return static_cast<std::uint64_t>(static_cast<std::int64_t>(value));
    case Form::float32:
      return std::bit_cast<std::uint32_t>(static_cast<float>(value));
    default:
      return std::bit_cast<std::uint64_t>(value);
  }
}

// The narrowest form from `at_least` on that holds the value.
[[nodiscard]] Form form_of(double value, Form at_least) noexcept {
  if (at_least == Form::integer && std::abs(value) <= kMostInteger &&
      same(value_of(bits_of(value, Form::integer), Form::integer), value))
    return Form::integer;
  if (at_least <= Form::float32 && same(value_of(bits_of(value, Form::float32), Form::float32), value))
    return Form::float32;
  return Form::float64;
}

// Makes small signed numbers small unsigned ones: 0, -1, 1, -2 … become 0, 1, 2, 3 …
[[nodiscard]] constexpr std::uint64_t zigzag(std::uint64_t x) noexcept { return (x << 1) ^ (0 - (x >> 63)); }
[[nodiscard]] constexpr std::uint64_t unzigzag(std::uint64_t z) noexcept { return (z >> 1) ^ (0 - (z & 1)); }

// Predicts the next record of one kind and channel.
struct Track {
  std::uint32_t key = 0;
  std::uint32_t follower = 0;               // track of the record that followed this track's last one
  std::uint64_t gap = 0;                    // t_ns less that of the record before it
  std::uint64_t last = 0, before_last = 0;  // values in `form`
  std::uint32_t half = 0;
  Form form = Form::integer;

  // Extrapolated linearly in time, modulo 2^64: plain differences grow with the frequency of the motion.
  [[nodiscard]] std::uint64_t predicted(Form now) noexcept {
    if (now != form) last = before_last = 0;
    form = now;
    return 2 * last - before_last;
  }
  void take(std::uint64_t bits) noexcept {
    before_last = last;
    last = bits;
  }
};

class Tracks {
 public:
  [[nodiscard]] Track& of(Kind kind, std::uint16_t channel) {
    const std::uint32_t key = static_cast<std::uint32_t>(kind) << 16U | channel;
    // Channels mostly come in the same order again. Then no look-up in the index is needed.
    std::uint32_t at = tracks_[at_].follower;
    if (tracks_[at].key != key) {
      const auto [found, fresh] = index_.try_emplace(key, static_cast<std::uint32_t>(tracks_.size()));
      if (fresh) tracks_.push_back({.key = key});
      at = found->second;
      tracks_[at_].follower = at;
    }
    at_ = at;
    return tracks_[at];
  }

 private:
  static constexpr std::uint32_t kNoKey = 0xFFFFFFFF;  // keys have 24 bits
  std::vector<Track> tracks_ = {{.key = kNoKey}};
  std::unordered_map<std::uint32_t, std::uint32_t> index_;
  std::uint32_t at_ = 0;
};

// A part of a block as numbers, most of them small.
constexpr std::size_t kRows = 512;
struct RecordColumns {
  std::array<std::uint8_t, kRows> kind, flags, form;
  std::array<std::uint16_t, kRows> channel;
  std::array<std::uint32_t, kRows> half;
  std::array<std::uint64_t, kRows> instant, delay, value;
};

// Turns records into numbers, or numbers into records. It must see the records of a block in order.
class Predictor {
 public:
  void to_numbers(const Record& r, RecordColumns& to, std::size_t i) {
    Track& track = tracks_.of(r.kind, r.channel);
    to.kind[i] = static_cast<std::uint8_t>(r.kind);
    to.flags[i] = r.flags;
    to.channel[i] = r.channel;
    to.half[i] = r.t_half_ns - track.half;
    track.half = r.t_half_ns;
    const auto t = static_cast<std::uint64_t>(r.t_ns);
    to.instant[i] = zigzag(t - t_ - track.gap);
    track.gap = t - t_;
    t_ = t;
    std::uint64_t& delay = delays_[to.kind[i]];
    const std::uint64_t delay_now = static_cast<std::uint64_t>(r.stamped_ns) - t;
    to.delay[i] = zigzag(delay_now - delay);
    delay = delay_now;
    const Form form = form_of(r.value, track.form);
    const std::uint64_t bits = bits_of(r.value, form);
    to.form[i] = static_cast<std::uint8_t>(form);
    to.value[i] = zigzag(bits - track.predicted(form));
    track.take(bits);
  }

  // Fills every field of `r` in its place: a copy just made of narrow fields stalls the processor.
  void to_record(const RecordColumns& from, std::size_t i, Record& r) {
    r.channel = from.channel[i];
    r.kind = static_cast<Kind>(from.kind[i]);
    r.flags = from.flags[i];
    Track& track = tracks_.of(r.kind, r.channel);
    r.t_half_ns = track.half += from.half[i];
    track.gap += unzigzag(from.instant[i]);
    t_ += track.gap;
    r.t_ns = static_cast<std::int64_t>(t_);
    std::uint64_t& delay = delays_[from.kind[i]];
    delay += unzigzag(from.delay[i]);
    r.stamped_ns = static_cast<std::int64_t>(t_ + delay);
    const auto form = static_cast<Form>(from.form[i]);
    const std::uint64_t bits = track.predicted(form) + unzigzag(from.value[i]);
    track.take(bits);
    r.value = value_of(bits, form);
  }

 private:
  Tracks tracks_;
  std::uint64_t t_ = 0;                      // of the record before
  std::array<std::uint64_t, 256> delays_{};  // by kind, of its record before: stamped_ns less t_ns
};

// Writes `count` numbers as bytes `at` … of a column's planes, each `n` long.
template <class Number>
void split(const Number* numbers, std::size_t count, Column column, Byte* planes, std::size_t n, std::size_t at) {
  for (std::size_t k = 0; k < column.bytes; ++k) {
    Byte* plane = planes + (column.plane + k) * n + at;
    for (std::size_t i = 0; i < count; ++i) plane[i] = static_cast<Byte>(numbers[i] >> 8 * k);
  }
}

template <class Number>
void join(Number* numbers, std::size_t count, Column column, const Byte* planes, std::size_t n, std::size_t at) {
  std::fill_n(numbers, count, Number{0});
  for (std::size_t k = 0; k < column.bytes; ++k) {
    const Byte* plane = planes + (column.plane + k) * n + at;
    Byte any = 0;  // most planes are all zeros: to see that costs a tenth of adding them
    for (std::size_t i = 0; i < count; ++i) any |= plane[i];
    if (any == 0) continue;
    for (std::size_t i = 0; i < count; ++i) numbers[i] = static_cast<Number>(numbers[i] | Number{plane[i]} << 8 * k);
  }
}

// Calls each(numbers, column) for every column.
template <class AnyColumns, class Each>
void for_each_column(AnyColumns& stretch, const Each& each) {
  each(stretch.kind.data(), kKind);
  each(stretch.flags.data(), kFlags);
  each(stretch.form.data(), kForm);
  each(stretch.channel.data(), kChannel);
  each(stretch.half.data(), kHalf);
  each(stretch.instant.data(), kInstant);
  each(stretch.delay.data(), kDelay);
  each(stretch.value.data(), kValue);
}

[[nodiscard]] std::uint32_t number_at(std::string_view bytes, std::size_t at) noexcept {
  std::uint32_t number = 0;
  for (std::size_t k = 0; k < 4; ++k) number |= std::uint32_t{static_cast<Byte>(bytes[at + k])} << 8 * k;
  return number;
}

void put_number(std::string& bytes, std::uint32_t number) {
  for (std::size_t k = 0; k < 4; ++k) bytes.push_back(static_cast<char>(number >> 8 * k));
}

// One zstd frame of all planes. Throws std::bad_alloc where there is no memory.
void compress(const std::vector<Byte>& planes, std::string& out) {
  const std::size_t begin = out.size();
  out.resize(begin + ZSTD_compressBound(planes.size()));
  const std::size_t got = ZSTD_compress(out.data() + begin, out.size() - begin, planes.data(), planes.size(), kLevel);
  if (ZSTD_isError(got)) throw std::bad_alloc();  // there is room: only zstd's own memory can be missing
  out.resize(begin + got);
}

}  // namespace

std::string encode_block(std::span<const Record> records) {
  const std::size_t n = records.size();
  std::string out;
  put_number(out, kBlockVersion);
  put_number(out, static_cast<std::uint32_t>(n));
  std::vector<Byte> planes(kPlanes * n);
  Predictor predictor;
  RecordColumns stretch;
  for (std::size_t at = 0; at < n; at += kRows) {
    const std::size_t count = std::min(kRows, n - at);
    for (std::size_t i = 0; i < count; ++i) predictor.to_numbers(records[at + i], stretch, i);
    for_each_column(stretch,
                    [&](const auto* numbers, Column column) { split(numbers, count, column, planes.data(), n, at); });
  }
  compress(planes, out);
  return out;
}

namespace {

// The planes of a block of `n` records. Checks the size that the frame states before it allocates anything.
[[nodiscard]] Result<std::unique_ptr<Byte[]>> decompress(std::string_view frame, std::size_t n) {
  const std::size_t size = kPlanes * n;
  if (ZSTD_getFrameContentSize(frame.data(), frame.size()) != size)
    return tl::unexpected("block of " + std::to_string(n) + " records: its zstd frame does not say that it holds " +
                          std::to_string(size) + " bytes");
  if (ZSTD_findFrameCompressedSize(frame.data(), frame.size()) != frame.size())
    return tl::unexpected("block of " + std::to_string(n) + " records: its zstd frame does not end with the block");
  auto planes = std::make_unique_for_overwrite<Byte[]>(size);
  const std::size_t got = ZSTD_decompress(planes.get(), size, frame.data(), frame.size());
  if (ZSTD_isError(got))
    return tl::unexpected("block of " + std::to_string(n) + " records: zstd says: " + ZSTD_getErrorName(got));
  if (got != size)
    return tl::unexpected("block of " + std::to_string(n) + " records: its zstd frame holds " + std::to_string(got) +
                          " bytes instead of " + std::to_string(size));
  return planes;
}

// As decode_block(), but where it fails `out` keeps the records that it held.
[[nodiscard]] Result<void> decode(std::string_view bytes, std::vector<Record>& out) {
  if (bytes.size() < kPreamble)
    return tl::unexpected("block of " + std::to_string(bytes.size()) + " bytes: a block has at least " +
                          std::to_string(kPreamble));
  if (const std::uint32_t version = number_at(bytes, 0); version != kBlockVersion)
    return tl::unexpected("block of version " + std::to_string(version) + ": only version " +
                          std::to_string(kBlockVersion) + " is known");
  const std::size_t n = number_at(bytes, 4);
  if (n > kMaxBlockRecords)
    return tl::unexpected("block of " + std::to_string(n) + " records: at most " + std::to_string(kMaxBlockRecords) +
                          " are allowed");
  const auto planes = decompress(bytes.substr(kPreamble), n);
  if (!planes) return tl::unexpected(planes.error());
  const Byte* forms = planes->get() + kForm.plane * n;
  const Byte* unknown = std::find_if(forms, forms + n, [](Byte form) { return form > kMostForm; });
  if (unknown != forms + n)
    return tl::unexpected("block of " + std::to_string(n) + " records: record " + std::to_string(unknown - forms + 1) +
                          " has a value of form " + std::to_string(*unknown) + ", forms end at " +
                          std::to_string(kMostForm));
  out.resize(n);
  Predictor predictor;
  RecordColumns stretch;
  for (std::size_t at = 0; at < n; at += kRows) {
    const std::size_t count = std::min(kRows, n - at);
    for_each_column(stretch, [&](auto* numbers, Column column) { join(numbers, count, column, planes->get(), n, at); });
    for (std::size_t i = 0; i < count; ++i) predictor.to_record(stretch, i, out[at + i]);
  }
  return {};
}

}  // namespace

// Overwrites the records that `out` holds: clearing them first would cost as much as copying the new ones.
Result<void> decode_block(std::string_view bytes, std::vector<Record>& out) {
  auto decoded = decode(bytes, out);
  if (!decoded) out.clear();
  return decoded;
}

}  // namespace dwell::record
