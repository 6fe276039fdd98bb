#include "core/fit/open_block.hpp"

#include <algorithm>
#include <cassert>
#include <type_traits>

#include "core/base/instants.hpp"
#include "core/rig/rig.hpp"

namespace dwell {
namespace {

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

OpenBlock::OpenBlock(int channels, int harmonics) : instants_count_(2 * harmonics + 1) {
  members_.resize(static_cast<std::size_t>(channels), Member{0, -1, INT64_MIN, 1, 0, 0.0, 0.0, nullptr, nullptr});
  with_constant(harmonics, [this](auto constant) {
    constexpr int kH = decltype(constant)::value;
    evaluate_ = &moments::evaluate<kH>;
    add_instant_ = &moments::add<2 * kH + 1>;
    add_sample_ = &add_sample<kH>;
  });
  reset();
}

void OpenBlock::reset() noexcept {
  for (int c = 0; c < channels(); ++c) {
    member(c).leader = c;
    member(c).next = -1;
    member(c).size = 1;
  }
  open_ = false;
}

void OpenBlock::open(MomentSets& sets, std::size_t slot, std::int64_t centre_ns, std::int64_t end_ns,
                     double omega) noexcept {
  slot_ = slot;
  centre_ns_ = centre_ns;
  end_ns_ = end_ns;
  omega_ = omega;
  sets.clear(slot);
  for (int c = 0; c < channels(); ++c) {
    Member& member = this->member(c);
    if (member.leader == c) sets.clear_instants(slot, c);  // break_away() fills those of the others
    member.last_ns = INT64_MIN;
    member.count = 0.0;
    member.arrived = member.size;
    member.instants = sets.instants(slot, c);
    member.readings = sets.readings(slot, c);
  }
  now_.t_ns = INT64_MIN;
  open_ = true;
}

void OpenBlock::evaluate(std::int64_t t_ns, moments::Regressors& out) const noexcept {
  const double u = to_s(t_ns - centre_ns_);
  out.t_ns = t_ns;
  evaluate_(omega_ * u, u, out);
}

template <int H>
void OpenBlock::add_sample(OpenBlock& block, int channel, std::int64_t t_ns, double value) noexcept {
  moments::Regressors& now = block.now_;
  if (t_ns != now.t_ns) {
    assert(block.open_ && t_ns < block.end_ns_);
    const double u = to_s(t_ns - block.centre_ns_);
    now.t_ns = t_ns;
    moments::evaluate<H>(block.omega_ * u, u, now);
  }
  Member& member = block.member(channel);
  Member* leader = &block.member(member.leader);
  if (leader->last_ns != t_ns) {
    if (leader->arrived != leader->size) {
      block.settle_members(member.leader);
      leader = &block.member(member.leader);  // the leader may have left its group
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

// Gives each channel that missed its group's newest instant a set of its own.
void OpenBlock::settle_members(int leader) noexcept {
  const double instants_so_far = member(leader).instants[0];
  for (int c = leader; c >= 0;) {
    const int next = member(c).next;
    if (member(c).count != instants_so_far) break_away(c);
    c = next;
  }
}

void OpenBlock::break_away(int c) noexcept {
  Member& member = this->member(c);
  const int leader = member.leader;
  const std::size_t set = moments::size(instants_count_);
  moments::Regressors missed;
  evaluate(this->member(leader).last_ns, missed);
  assert(leader != c || member.next >= 0);  // the channel that brought that instant stays in the group
  if (leader == c) {                        // the set passes to the next channel in the group
    Member& heir = this->member(member.next);
    heir.size = member.size - 1;
    heir.arrived = member.arrived;
    std::copy_n(member.instants, set, heir.instants);
    heir.last_ns = member.last_ns;
    for (int f = member.next; f >= 0; f = this->member(f).next) this->member(f).leader = member.next;
  } else {
    int before = leader;
    while (this->member(before).next != c) before = this->member(before).next;
    this->member(before).next = member.next;
    --this->member(leader).size;
    std::copy_n(this->member(leader).instants, set, member.instants);
  }
  member.leader = c;
  member.next = -1;
  member.size = member.arrived = 1;
  member.last_ns = INT64_MIN;  // the missed instant leaves its set and may still come
  add_instant_(missed, -1.0, -missed.u * missed.u, member.instants);
}

// Lets channels whose instants were the same throughout this block share one set in the next.
void OpenBlock::regroup(const MomentSets& sets) noexcept {
  for (int c = 0; c < channels(); ++c) {
    Member& member = this->member(c);
    const double* own = sets.shared_instants(slot_, c);
    member.leader = c;
    member.next = -1;
    member.size = 1;
    if (own[0] == 0) continue;
    for (int l = 0; l < c; ++l) {
      Member& leader = this->member(l);
      if (leader.leader != l) continue;
      const double* other = sets.shared_instants(slot_, l);
      // Equal number, Σu and Σu², bit for bit: equal instants are summed in the same order.
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

void OpenBlock::close(MomentSets& sets) noexcept {
  assert(open_);
  for (int c = 0; c < channels(); ++c)
    if (member(c).leader == c) settle_members(c);
  // Every leader's set is now that of its whole group: a leader that left has handed the group to an heir.
  for (int c = 0; c < channels(); ++c) sets.share(slot_, c, member(c).leader);
  regroup(sets);
  open_ = false;
}

// Takes out the group's newest instant if the channel has not got it (yet).
const double* OpenBlock::instants_of(int c, double* scratch) const noexcept {
  const double* set = shared_instants(c);
  if (set[0] == member(c).count) return set;
  std::copy_n(set, moments::size(instants_count_), scratch);
  moments::Regressors newest;
  evaluate(member(member(c).leader).last_ns, newest);
  add_instant_(newest, -1.0, -newest.u * newest.u, scratch);
  return scratch;
}

void OpenBlock::add_to(Totals& out, const moments::Turn& turn) const noexcept {
  double scratch[moments::size(2 * kMaxHarmonics + 1)];
  for (int c = 0; c < channels(); ++c) out.share(c, shared_instants(c)[0] == member(c).count ? member(c).leader : c);
  for (int c = 0; c < channels(); ++c) out.add(c, {instants_of(c, scratch), member(c).readings}, turn);
}

}  // namespace dwell
