#include "core/blocks.hpp"

#include <algorithm>
#include <cassert>
#include <utility>

#include "core/rig.hpp"

namespace dwell {
namespace {

constexpr double kSecond = 1e-9;  // s per ns

double seconds(std::int64_t ns) noexcept { return static_cast<double>(ns) * kSecond; }

// The inner loops know H at compile time, which lets them unroll; this table picks the right ones once.
template <int H>
struct Kernel {
  static void evaluate(double theta, double u, moments::Regressors& out) { moments::evaluate<H>(theta, u, out); }
  static void instant(const moments::Regressors& x, double w, double* set) { moments::add<2 * H + 1>(x, w, set); }
  static void reading(const moments::Regressors& x, double w, double* set) { moments::add<H + 1>(x, w, set); }
};

template <typename F>
void with_kernel(int harmonics, F&& use) {
  switch (harmonics) {
    case 1:
      return use(Kernel<1>{});
    case 2:
      return use(Kernel<2>{});
    case 3:
      return use(Kernel<3>{});
    case 4:
      return use(Kernel<4>{});
    case 5:
      return use(Kernel<5>{});
    case 6:
      return use(Kernel<6>{});
    case 7:
      return use(Kernel<7>{});
    case 8:
      return use(Kernel<8>{});
    default:
      assert(false && "harmonics outside 1 … kMaxHarmonics");
  }
}
static_assert(kMaxHarmonics == 8);

}  // namespace

Totals::Totals(int channels, int harmonics)
    : instants_count_(2 * harmonics + 1),
      readings_count_(harmonics + 1),
      instants_(moments::size(instants_count_) * static_cast<std::size_t>(channels)),
      readings_(moments::size(readings_count_) * static_cast<std::size_t>(channels)),
      sum_squares_(static_cast<std::size_t>(channels)),
      owner_(static_cast<std::size_t>(channels)) {}

ChannelMoments Totals::channel(int c) const noexcept {
  const auto i = static_cast<std::size_t>(c);
  return {&instants_[moments::size(instants_count_) * static_cast<std::size_t>(owner_[i])],
          &readings_[moments::size(readings_count_) * i], sum_squares_[i]};
}

Blocks::Blocks(int channels, int harmonics)
    : channels_(channels),
      harmonics_(harmonics),
      instants_count_(2 * harmonics + 1),
      readings_count_(harmonics + 1),
      instants_size_(moments::size(instants_count_)),
      readings_size_(moments::size(readings_count_)) {
  constexpr std::size_t kSlots = kCapacity + 2;  // and the open one, and one for joining
  const auto per_slot = static_cast<std::size_t>(channels);
  instants_.resize(kSlots * per_slot * instants_size_);
  readings_.resize(kSlots * per_slot * readings_size_);
  slots_.resize(kSlots * per_slot);
  blocks_.resize(kSlots);
  reference_.resize(per_slot);
  members_.resize(per_slot);
  order_.reserve(kSlots);
  free_.reserve(kSlots);
  with_kernel(harmonics, [this](auto kernel) {
    evaluate_ = &kernel.evaluate;
    add_instant_ = &kernel.instant;
    add_reading_ = &kernel.reading;
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
Blocks::Slot& Blocks::at(std::size_t slot, int c) noexcept {
  return slots_[slot * static_cast<std::size_t>(channels_) + static_cast<std::size_t>(c)];
}
const Blocks::Slot& Blocks::at(std::size_t slot, int c) const noexcept {
  return slots_[slot * static_cast<std::size_t>(channels_) + static_cast<std::size_t>(c)];
}

void Blocks::clear() noexcept {
  order_.clear();
  free_.clear();
  for (std::size_t slot = blocks_.size(); slot-- > 0;) free_.push_back(static_cast<std::uint16_t>(slot));
  for (int c = 0; c < channels_; ++c) members_[static_cast<std::size_t>(c)] = {c, -1, INT64_MIN, 0.0};
  open_ = false;
  serials_ = 0;
}

void Blocks::open(std::int64_t begin_ns, std::int64_t end_ns, double omega) noexcept {
  assert(!open_ && end_ns > begin_ns);
  current_ = free_.back();
  free_.pop_back();
  blocks_[current_] = {begin_ns, end_ns, begin_ns + (end_ns - begin_ns) / 2, omega, serials_, 1};
  std::fill_n(instants(current_, 0), instants_size_ * static_cast<std::size_t>(channels_), 0.0);
  std::fill_n(readings(current_, 0), readings_size_ * static_cast<std::size_t>(channels_), 0.0);
  for (int c = 0; c < channels_; ++c) {
    at(current_, c) = {0.0, c};
    members_[static_cast<std::size_t>(c)].last_ns = INT64_MIN;
    members_[static_cast<std::size_t>(c)].count = 0.0;
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

void Blocks::add(int channel, std::int64_t t_ns, double value) noexcept {
  assert(open_ && t_ns < blocks_[current_].end_ns);
  if (t_ns != now_.t_ns) evaluate(t_ns, now_);
  Member& member = members_[static_cast<std::size_t>(channel)];
  if (members_[static_cast<std::size_t>(member.leader)].last_ns != t_ns) {
    settle_members(member.leader);
    add_instant_(now_, 1.0, instants(current_, member.leader));
    members_[static_cast<std::size_t>(member.leader)].last_ns = t_ns;
  }
  member.count += 1.0;
  const double s = value - reference_[static_cast<std::size_t>(channel)];
  add_reading_(now_, s, readings(current_, channel));
  at(current_, channel).sum_squares += s * s;
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
    std::copy_n(instants(current_, c), instants_size_, instants(current_, heir));
    members_[static_cast<std::size_t>(heir)].last_ns = member.last_ns;
    for (int f = heir; f >= 0; f = members_[static_cast<std::size_t>(f)].next)
      members_[static_cast<std::size_t>(f)].leader = heir;
  } else {
    int before = leader;
    while (members_[static_cast<std::size_t>(before)].next != c)
      before = members_[static_cast<std::size_t>(before)].next;
    members_[static_cast<std::size_t>(before)].next = member.next;
    std::copy_n(instants(current_, leader), instants_size_, instants(current_, c));
  }
  member.leader = c;
  member.next = -1;
  add_instant_(missed, -1.0, instants(current_, c));
}

// Channels whose instants were the same throughout the block that ends share one set in the next.
void Blocks::regroup() noexcept {
  for (int c = 0; c < channels_; ++c) {
    Member& member = members_[static_cast<std::size_t>(c)];
    const double* own = instants(current_, at(current_, c).owner);
    member.leader = c;
    member.next = -1;
    if (own[0] == 0) continue;
    for (int l = 0; l < c; ++l) {
      Member& leader = members_[static_cast<std::size_t>(l)];
      if (leader.leader != l) continue;
      const double* other = instants(current_, at(current_, l).owner);
      // Number, Σu and Σu² of the instants, bit for bit: both were added up in the same order.
      const bool same = own == other ||
                        (own[0] == other[0] &&
                         own[moments::cosine(instants_count_, 1, 0)] == other[moments::cosine(instants_count_, 1, 0)] &&
                         own[moments::cosine(instants_count_, 2, 0)] == other[moments::cosine(instants_count_, 2, 0)]);
      if (!same) continue;
      member.leader = l;
      member.next = leader.next;
      leader.next = c;
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
  for (int c = 0; c < channels_; ++c) at(current_, c).owner = members_[static_cast<std::size_t>(c)].leader;
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
  if (order_.size() > kCapacity) {
    free_.push_back(order_.front());
    order_.erase(order_.begin());
  }
}

void Blocks::sum_instants(std::size_t slot, const Block& block, int c, double omega, std::int64_t t_ref_ns,
                          double* out) const noexcept {
  const double shift = seconds(block.centre_ns - t_ref_ns);
  moments::rebase_add(instants(slot, at(slot, c).owner), instants_count_, omega - block.omega, omega * shift, shift,
                      out);
}

void Blocks::sum_readings(std::size_t slot, const Block& block, int c, double omega, std::int64_t t_ref_ns,
                          double* out) const noexcept {
  const double shift = seconds(block.centre_ns - t_ref_ns);
  moments::rebase_add(readings(slot, c), readings_count_, omega - block.omega, omega * shift, shift, out);
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
  for (int c = 0; c < channels_; ++c) {
    const int shared = at(older, c).owner;
    const int owner = shared == at(newer, c).owner ? shared : c;
    at(into, c) = {at(older, c).sum_squares + at(newer, c).sum_squares, owner};
    for (const auto& [slot, block] : {std::pair{older, a}, std::pair{newer, b}}) {
      if (owner == c) sum_instants(slot, block, c, sum.omega, sum.centre_ns, instants(into, c));
      sum_readings(slot, block, c, sum.omega, sum.centre_ns, readings(into, c));
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

void Blocks::forget_before(std::int64_t t_ns) noexcept {
  std::size_t gone = 0;
  while (gone < order_.size() && blocks_[order_[gone]].end_ns <= t_ns) free_.push_back(order_[gone++]);
  order_.erase(order_.begin(), order_.begin() + static_cast<std::ptrdiff_t>(gone));
}

double Blocks::samples(int i, int channel) const noexcept {
  const std::size_t slot = order_[static_cast<std::size_t>(i)];
  return instants(slot, at(slot, channel).owner)[0];
}

void Blocks::sum(int from, int to, bool with_open, double omega, std::int64_t t_ref_ns, Totals& out) const noexcept {
  for (int c = 0; c < channels_; ++c) {
    int owner = -1;
    for (int i = from; i < to && owner != c; ++i) {
      const int shared = at(order_[static_cast<std::size_t>(i)], c).owner;
      owner = owner == -1 || owner == shared ? shared : c;
    }
    // In the open block a channel may not have got the newest instant of its group yet.
    out.owner_[static_cast<std::size_t>(c)] = owner == -1 || (with_open && open_) ? c : owner;
  }
  for (int c = 0; c < channels_; ++c) {
    sum_one(c, out.owner_[static_cast<std::size_t>(c)] == c, from, to, with_open, omega, t_ref_ns, out);
  }
  out.omega = omega;
  out.t_ref_ns = t_ref_ns;
}

void Blocks::sum_channel(int channel, int from, int to, bool with_open, double omega, std::int64_t t_ref_ns,
                         Totals& out) const noexcept {
  out.owner_[static_cast<std::size_t>(channel)] = channel;
  out.omega = omega;
  out.t_ref_ns = t_ref_ns;
  sum_one(channel, true, from, to, with_open, omega, t_ref_ns, out);
}

void Blocks::sum_one(int channel, bool with_instants, int from, int to, bool with_open, double omega,
                     std::int64_t t_ref_ns, Totals& out) const noexcept {
  const auto c = static_cast<std::size_t>(channel);
  double* instants_sum = &out.instants_[c * instants_size_];
  double* readings_sum = &out.readings_[c * readings_size_];
  std::fill_n(instants_sum, instants_size_, 0.0);
  std::fill_n(readings_sum, readings_size_, 0.0);
  out.sum_squares_[c] = 0.0;
  for (int i = from; i < to; ++i) {
    const std::size_t slot = order_[static_cast<std::size_t>(i)];
    if (with_instants) sum_instants(slot, blocks_[slot], channel, omega, t_ref_ns, instants_sum);
    sum_readings(slot, blocks_[slot], channel, omega, t_ref_ns, readings_sum);
    out.sum_squares_[c] += at(slot, channel).sum_squares;
  }
  if (!with_open || !open_) return;
  const Member& member = members_[c];
  double set[moments::size(2 * kMaxHarmonics + 1)];
  std::copy_n(instants(current_, member.leader), instants_size_, set);
  if (set[0] != member.count) {
    moments::Regressors newest;
    evaluate(members_[static_cast<std::size_t>(member.leader)].last_ns, newest);
    add_instant_(newest, -1.0, set);
  }
  const Block& block = blocks_[current_];
  const double shift = seconds(block.centre_ns - t_ref_ns);
  moments::rebase_add(set, instants_count_, omega - block.omega, omega * shift, shift, instants_sum);
  sum_readings(current_, block, channel, omega, t_ref_ns, readings_sum);
  out.sum_squares_[c] += at(current_, channel).sum_squares;
}

}  // namespace dwell
