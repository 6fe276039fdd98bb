#include "core/fit/blocks.hpp"

#include <cassert>

namespace dwell {
namespace {

constexpr std::size_t kSlots = Blocks::kCapacity + 2;  // plus the open block, plus one for joining

double seconds(std::int64_t ns) noexcept { return static_cast<double>(ns) * 1e-9; }

}  // namespace

Blocks::Blocks(int channels, int harmonics) : sets_(kSlots, channels, harmonics), newest_(channels, harmonics) {
  blocks_.resize(kSlots);
  order_.reserve(kSlots);
  free_.reserve(kSlots);
  clear();
}

void Blocks::clear() noexcept {
  restart();
  serials_ = 0;
}

void Blocks::restart() noexcept {
  order_.clear();
  free_.clear();
  for (std::size_t slot = blocks_.size(); slot-- > 0;) free_.push_back(static_cast<std::uint16_t>(slot));
  newest_.reset();
}

void Blocks::open(std::int64_t begin_ns, std::int64_t end_ns, double omega) noexcept {
  assert(!is_open() && end_ns > begin_ns);
  const std::size_t slot = free_.back();
  free_.pop_back();
  const std::int64_t centre_ns = begin_ns + (end_ns - begin_ns) / 2;
  blocks_[slot] = {begin_ns, end_ns, centre_ns, omega, serials_, 1};
  newest_.open(sets_, slot, centre_ns, end_ns, omega);
}

void Blocks::close() noexcept {
  newest_.close(sets_);
  order_.push_back(static_cast<std::uint16_t>(newest_.slot()));
  ++serials_;
  compact();
}

void Blocks::compact() noexcept {
  int quarters = 1, of_this_length = 0;
  for (std::size_t i = order_.size(); i-- > 0;) {
    const int older = i == 0 ? 0 : blocks_[order_[i - 1]].quarters;
    ++of_this_length;
    if (older == quarters) continue;
    if (of_this_length > (quarters == 1 ? kFine : kPerLength)) join(i);
    quarters = older;
    of_this_length = 0;
  }
  // No data may be lost, since running sums contain them: beyond the capacity the oldest two are joined.
  if (order_.size() > kCapacity) join(0);
}

void Blocks::join(std::size_t position) noexcept {
  const std::size_t older = order_[position], newer = order_[position + 1];
  const std::size_t into = free_.back();
  free_.pop_back();
  const Block& a = blocks_[older];
  const Block& b = blocks_[newer];
  Block& sum = blocks_[into];
  sum = {a.begin_ns, b.end_ns,       a.begin_ns + (b.end_ns - a.begin_ns) / 2,
         b.omega,    a.first_serial, a.quarters + b.quarters};
  const auto part = [&](std::size_t slot) -> MomentSets::Part {
    const Block& block = blocks_[slot];
    const double shift = seconds(block.centre_ns - sum.centre_ns);
    return {slot, {sum.omega - block.omega, sum.omega * shift, shift, sets_.instants_count()}};
  };
  sets_.join(part(older), part(newer), into);
  order_[position] = static_cast<std::uint16_t>(into);
  order_.erase(order_.begin() + static_cast<std::ptrdiff_t>(position) + 1);
  free_.push_back(static_cast<std::uint16_t>(older));
  free_.push_back(static_cast<std::uint16_t>(newer));
}

int Blocks::index_of(std::int64_t serial) const noexcept {
  int i = count();
  while (i > 0 && block(i - 1).first_serial >= serial) --i;
  return i;
}

bool Blocks::forget_before(std::int64_t t_ns) noexcept {
  std::size_t gone = 0;
  while (gone < order_.size() && blocks_[order_[gone]].end_ns <= t_ns) free_.push_back(order_[gone++]);
  order_.erase(order_.begin(), order_.begin() + static_cast<std::ptrdiff_t>(gone));
  return gone > 0;
}

double Blocks::samples(int i, int channel) const noexcept {
  return sets_.shared_instants(order_[static_cast<std::size_t>(i)], channel)[0];
}

moments::Turn Blocks::turn_into(const Totals& out, std::size_t slot) const noexcept {
  const Block& block = blocks_[slot];
  const double u = seconds(block.centre_ns - drift_.about_ns);
  return out.turn_from(block.omega, block.centre_ns, drift_.rate * u, 0.5 * drift_.rate * u * u);
}

void Blocks::add_block(int i, Totals& out) const noexcept {
  const std::size_t slot = order_[static_cast<std::size_t>(i)];
  const moments::Turn turn = turn_into(out, slot);
  for (int c = 0; c < sets_.channels(); ++c) out.share(c, sets_.owner(slot, c));
  for (int c = 0; c < sets_.channels(); ++c) out.add(c, sets_of(slot, c), turn);
}

void Blocks::add_open(Totals& out) const noexcept {
  if (is_open()) newest_.add_to(out, turn_into(out, newest_.slot()));
}

void Blocks::sum(int from, int to, double omega, std::int64_t t_ref_ns, Totals& out) const noexcept {
  out.restart(omega, t_ref_ns);
  for (int i = from; i < to; ++i) add_block(i, out);
}

void Blocks::sum_channel(int channel, int from, int to, double omega, std::int64_t t_ref_ns,
                         Totals& out) const noexcept {
  out.restart_channel(channel, omega, t_ref_ns);
  for (int i = from; i < to; ++i) {
    const std::size_t slot = order_[static_cast<std::size_t>(i)];
    out.add(channel, sets_of(slot, channel), turn_into(out, slot));
  }
}

}  // namespace dwell
