#include "core/fit/blocks.hpp"

#include <algorithm>
#include <cassert>
#include <type_traits>

#include "core/rig/rig.hpp"

namespace dwell {
namespace {

constexpr double kSecond = 1e-9;  // s per ns

double seconds(std::int64_t ns) noexcept { return static_cast<double>(ns) * kSecond; }

template <typename F>
void with_constant(int harmonics, F&& use) {
  switch (harmonics) {
    case 1:
      return use(std::integral_constant<int, 1>{});
    case 2:
      return use(std::integral_constant<int, 2>{});
    case 3:
      return use(std::integral_constant<int, 3>{});
    case 4:
      return use(std::integral_constant<int, 4>{});
    case 5:
      return use(std::integral_constant<int, 5>{});
    case 6:
      return use(std::integral_constant<int, 6>{});
    case 7:
      return use(std::integral_constant<int, 7>{});
    case 8:
      return use(std::integral_constant<int, 8>{});
    default:
      assert(false && "harmonics outside 1 … kMaxHarmonics");
  }
}
static_assert(kMaxHarmonics == 8);

}  // namespace

Blocks::Blocks(int channels, int harmonics)
    : channels_(channels),
      instants_count_(2 * harmonics + 1),
      readings_count_(harmonics + 1),
      instants_size_(moments::size(instants_count_)),
      readings_size_(moments::size(readings_count_)) {
  constexpr std::size_t kSlots = kCapacity + 2;  // and the open one, and one for joining
  const auto per_slot = static_cast<std::size_t>(channels);
  instants_.resize(kSlots * per_slot * instants_size_);
  readings_.resize(kSlots * per_slot * readings_size_);
  owners_.resize(kSlots * per_slot);
  blocks_.resize(kSlots);
  members_.resize(per_slot, Member{0, -1, INT64_MIN, 1, 0, 0.0, 0.0, nullptr, nullptr});
  order_.reserve(kSlots);
  free_.reserve(kSlots);
  with_constant(harmonics, [this](auto constant) {
    constexpr int kH = decltype(constant)::value;
    evaluate_ = &moments::evaluate<kH>;
    add_instant_ = &moments::add<2 * kH + 1>;
    add_sample_ = &add_sample<kH>;
  });
  clear();
}

double* Blocks::instants(std::size_t slot, int c) noexcept {
  return &instants_[(slot * static_cast<std::size_t>(channels_) + static_cast<std::size_t>(c)) * instants_size_];
}
const double* Blocks::instants(std::size_t slot, int c) const noexcept {
  return &instants_[(slot * static_cast<std::size_t>(channels_) + static_cast<std::size_t>(c)) * instants_size_];
}
double* Blocks::readings(std::size_t slot, int c) noexcept {
  return &readings_[(slot * static_cast<std::size_t>(channels_) + static_cast<std::size_t>(c)) * readings_size_];
}
const double* Blocks::readings(std::size_t slot, int c) const noexcept {
  return &readings_[(slot * static_cast<std::size_t>(channels_) + static_cast<std::size_t>(c)) * readings_size_];
}
int& Blocks::owner(std::size_t slot, int c) noexcept {
  return owners_[slot * static_cast<std::size_t>(channels_) + static_cast<std::size_t>(c)];
}
int Blocks::owner(std::size_t slot, int c) const noexcept {
  return owners_[slot * static_cast<std::size_t>(channels_) + static_cast<std::size_t>(c)];
}

void Blocks::clear() noexcept {
  restart();
  serials_ = 0;
}

void Blocks::restart() noexcept {
  order_.clear();
  free_.clear();
  for (std::size_t slot = blocks_.size(); slot-- > 0;) free_.push_back(static_cast<std::uint16_t>(slot));
  for (int c = 0; c < channels_; ++c) {
    Member& member = members_[static_cast<std::size_t>(c)];
    member.leader = c;
    member.next = -1;
    member.size = 1;
  }
  open_ = false;
}

void Blocks::open(std::int64_t begin_ns, std::int64_t end_ns, double omega) noexcept {
  assert(!open_ && end_ns > begin_ns);
  current_ = free_.back();
  free_.pop_back();
  blocks_[current_] = {begin_ns, end_ns, begin_ns + (end_ns - begin_ns) / 2, omega, serials_, 1};
  std::fill_n(instants(current_, 0), instants_size_ * static_cast<std::size_t>(channels_), 0.0);
  std::fill_n(readings(current_, 0), readings_size_ * static_cast<std::size_t>(channels_), 0.0);
  for (int c = 0; c < channels_; ++c) {
    owner(current_, c) = c;
    Member& member = members_[static_cast<std::size_t>(c)];
    member.last_ns = INT64_MIN;
    member.count = 0.0;
    member.arrived = member.size;
    member.instants = instants(current_, c);
    member.readings = readings(current_, c);
  }
  now_.t_ns = INT64_MIN;
  open_ = true;
}

void Blocks::evaluate(std::int64_t t_ns, moments::Regressors& out) const noexcept {
  const Block& block = blocks_[current_];
  const double u = seconds(t_ns - block.centre_ns);
  out.t_ns = t_ns;
  evaluate_(block.omega * u, u, out);
}

template <int H>
void Blocks::add_sample(Blocks& blocks, int channel, std::int64_t t_ns, double value) noexcept {
  moments::Regressors& now = blocks.now_;
  if (t_ns != now.t_ns) {
    const Block& block = blocks.blocks_[blocks.current_];
    assert(blocks.open_ && t_ns < block.end_ns);
    const double u = seconds(t_ns - block.centre_ns);
    now.t_ns = t_ns;
    moments::evaluate<H>(block.omega * u, u, now);
  }
  Member& member = blocks.members_[static_cast<std::size_t>(channel)];
  Member* leader = &blocks.members_[static_cast<std::size_t>(member.leader)];
  if (leader->last_ns != t_ns) {
    if (leader->arrived != leader->size) {
      blocks.settle_members(member.leader);
      leader = &blocks.members_[static_cast<std::size_t>(member.leader)];  // it may have left its group
    }
    moments::add<2 * H + 1>(now, 1.0, now.u * now.u, leader->instants);
    leader->last_ns = t_ns;
    leader->arrived = 0;
  }
  ++leader->arrived;
  member.count += 1.0;
  const double s = value - member.reference;
  moments::add<H + 1>(now, s, s * s, member.readings);
}

// Whoever of a group has missed its newest instant goes on with a set of its own.
void Blocks::settle_members(int leader) noexcept {
  const double instants_so_far = instants(current_, leader)[0];
  for (int c = leader; c >= 0;) {
    const int next = members_[static_cast<std::size_t>(c)].next;
    if (members_[static_cast<std::size_t>(c)].count != instants_so_far) break_away(c);
    c = next;
  }
}

void Blocks::break_away(int c) noexcept {
  Member& member = members_[static_cast<std::size_t>(c)];
  const int leader = member.leader;
  moments::Regressors missed;
  evaluate(members_[static_cast<std::size_t>(leader)].last_ns, missed);
  assert(leader != c || member.next >= 0);  // whoever brought that instant has not missed it and stays in the group
  if (leader == c) {                        // the set passes to the next in the group
    const int heir = member.next;
    members_[static_cast<std::size_t>(heir)].size = member.size - 1;
    members_[static_cast<std::size_t>(heir)].arrived = member.arrived;
    std::copy_n(instants(current_, c), instants_size_, instants(current_, heir));
    members_[static_cast<std::size_t>(heir)].last_ns = member.last_ns;
    for (int f = heir; f >= 0; f = members_[static_cast<std::size_t>(f)].next)
      members_[static_cast<std::size_t>(f)].leader = heir;
  } else {
    int before = leader;
    while (members_[static_cast<std::size_t>(before)].next != c)
      before = members_[static_cast<std::size_t>(before)].next;
    members_[static_cast<std::size_t>(before)].next = member.next;
    --members_[static_cast<std::size_t>(leader)].size;
    std::copy_n(instants(current_, leader), instants_size_, instants(current_, c));
  }
  member.leader = c;
  member.next = -1;
  member.size = member.arrived = 1;
  member.last_ns = INT64_MIN;  // the instant it missed is not in its set, and may still come
  add_instant_(missed, -1.0, -missed.u * missed.u, instants(current_, c));
}

// Channels whose instants were the same throughout the block that ends share one set in the next.
void Blocks::regroup() noexcept {
  for (int c = 0; c < channels_; ++c) {
    Member& member = members_[static_cast<std::size_t>(c)];
    const double* own = instants(current_, owner(current_, c));
    member.leader = c;
    member.next = -1;
    member.size = 1;
    if (own[0] == 0) continue;
    for (int l = 0; l < c; ++l) {
      Member& leader = members_[static_cast<std::size_t>(l)];
      if (leader.leader != l) continue;
      const double* other = instants(current_, owner(current_, l));
      // Number, Σu and Σu² of the instants, bit for bit: both were added up in the same order.
      const bool same = own == other ||
                        (own[0] == other[0] &&
                         own[moments::cosine(instants_count_, 1, 0)] == other[moments::cosine(instants_count_, 1, 0)] &&
                         own[moments::squares(instants_count_)] == other[moments::squares(instants_count_)]);
      if (!same) continue;
      member.leader = l;
      member.next = leader.next;
      leader.next = c;
      ++leader.size;
      break;
    }
  }
}

void Blocks::close() noexcept {
  assert(open_);
  for (int c = 0; c < channels_; ++c)
    if (members_[static_cast<std::size_t>(c)].leader == c) settle_members(c);
  // A leader that left its group in this very pass has handed its followers over; an heir has the instant by
  // definition.
  for (int c = 0; c < channels_; ++c) owner(current_, c) = members_[static_cast<std::size_t>(c)].leader;
  regroup();
  order_.push_back(static_cast<std::uint16_t>(current_));
  open_ = false;
  ++serials_;
  compact();
}

void Blocks::compact() noexcept {
  int quarters = 1, of_this_length = 0;
  for (std::size_t i = order_.size(); i-- > 0;) {
    const Block& block = blocks_[order_[i]];
    if (block.quarters != quarters) quarters = block.quarters, of_this_length = 0;
    const bool oldest_of_length = i == 0 || blocks_[order_[i - 1]].quarters != quarters;
    if (++of_this_length > (quarters == 1 ? kFine : kPerLength) && oldest_of_length) join(i);
  }
  // What counts in running sums must not go: beyond all lengths the oldest two are one.
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
  std::fill_n(instants(into, 0), instants_size_ * static_cast<std::size_t>(channels_), 0.0);
  std::fill_n(readings(into, 0), readings_size_ * static_cast<std::size_t>(channels_), 0.0);
  for (int c = 0; c < channels_; ++c) owner(into, c) = owner(older, c) == owner(newer, c) ? owner(older, c) : c;
  for (const std::size_t slot : {older, newer}) {
    const Block& part = blocks_[slot];
    const double shift = seconds(part.centre_ns - sum.centre_ns);
    const moments::Turn turn{sum.omega - part.omega, sum.omega * shift, shift, instants_count_};
    for (int c = 0; c < channels_; ++c) {
      const double* set = instants(slot, owner(slot, c));
      if (owner(into, c) == c) moments::add_instants(set, instants_count_, turn, instants(into, c));
      moments::add_readings(readings(slot, c), readings_count_, turn, moments::mean_square_u(set, instants_count_),
                            readings(into, c));
    }
  }
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
  const std::size_t slot = order_[static_cast<std::size_t>(i)];
  return instants(slot, owner(slot, channel))[0];
}

void Blocks::part(int c, int owner_in_block, Totals& out) const noexcept {
  int& shared = out.owner_[static_cast<std::size_t>(c)];
  if (shared == owner_in_block || shared == c) return;
  if (shared >= 0) std::copy_n(out.instants(shared), instants_size_, out.instants(c));
  shared = shared < 0 ? owner_in_block : c;
}

moments::Turn Blocks::turn_into(const Totals& out, std::size_t slot) const noexcept {
  const Block& block = blocks_[slot];
  const double u = seconds(block.centre_ns - drift_.about_ns);
  return out.turn_from(block.omega, block.centre_ns, drift_.rate * u, 0.5 * drift_.rate * u * u);
}

void Blocks::add_block(int i, Totals& out) const noexcept {
  const std::size_t slot = order_[static_cast<std::size_t>(i)];
  const moments::Turn turn = turn_into(out, slot);
  for (int c = 0; c < channels_; ++c) part(c, owner(slot, c), out);
  for (int c = 0; c < channels_; ++c) {
    const double* set = instants(slot, owner(slot, c));
    if (out.owner_[static_cast<std::size_t>(c)] == c)
      moments::add_instants(set, instants_count_, turn, out.instants(c));
    moments::add_readings(readings(slot, c), readings_count_, turn, moments::mean_square_u(set, instants_count_),
                          out.readings(c));
  }
}

// A channel's instants in the open block; it may not have got the newest one of its group (yet).
const double* Blocks::open_instants(int c, double* scratch) const noexcept {
  const Member& member = members_[static_cast<std::size_t>(c)];
  const double* set = instants(current_, member.leader);
  if (set[0] == member.count) return set;
  std::copy_n(set, instants_size_, scratch);
  moments::Regressors newest;
  evaluate(members_[static_cast<std::size_t>(member.leader)].last_ns, newest);
  add_instant_(newest, -1.0, -newest.u * newest.u, scratch);
  return scratch;
}

void Blocks::add_open(Totals& out) const noexcept {
  if (!open_) return;
  const moments::Turn turn = turn_into(out, current_);
  double scratch[moments::size(2 * kMaxHarmonics + 1)];
  for (int c = 0; c < channels_; ++c) {
    const Member& member = members_[static_cast<std::size_t>(c)];
    part(c, instants(current_, member.leader)[0] == member.count ? member.leader : c, out);
  }
  for (int c = 0; c < channels_; ++c) {
    const double* set = open_instants(c, scratch);
    if (out.owner_[static_cast<std::size_t>(c)] == c)
      moments::add_instants(set, instants_count_, turn, out.instants(c));
    moments::add_readings(readings(current_, c), readings_count_, turn, moments::mean_square_u(set, instants_count_),
                          out.readings(c));
  }
}

void Blocks::sum(int from, int to, double omega, std::int64_t t_ref_ns, Totals& out) const noexcept {
  out.restart(omega, t_ref_ns);
  for (int i = from; i < to; ++i) add_block(i, out);
}

void Blocks::sum_channel(int channel, int from, int to, double omega, std::int64_t t_ref_ns,
                         Totals& out) const noexcept {
  out.omega_ = omega;
  out.t_ref_ns_ = t_ref_ns;
  out.owner_[static_cast<std::size_t>(channel)] = channel;
  std::fill_n(out.instants(channel), instants_size_, 0.0);
  std::fill_n(out.readings(channel), readings_size_, 0.0);
  for (int i = from; i < to; ++i) {
    const std::size_t slot = order_[static_cast<std::size_t>(i)];
    const moments::Turn turn = turn_into(out, slot);
    const double* set = instants(slot, owner(slot, channel));
    moments::add_instants(set, instants_count_, turn, out.instants(channel));
    moments::add_readings(readings(slot, channel), readings_count_, turn, moments::mean_square_u(set, instants_count_),
                          out.readings(channel));
  }
}

}  // namespace dwell
