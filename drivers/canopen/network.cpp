#include "drivers/canopen/network.hpp"

#include <algorithm>
#include <cstring>

#include "drivers/canopen/words.hpp"

namespace dwell::canopen {

Network::Network(Setup setup, const driver::Host& host)
    : setup_(std::move(setup)), host_(host), delivery_(host, setup_.channels) {
  members_.reserve(setup_.nodes.size());
  for (const Wish& wish : setup_.nodes) {
    members_.push_back({Node(wish, host_, outbox_), {}, 0});
    by_id_[wish.node & kNodeMask] = &members_.back();
  }
}

std::vector<can_filter> Network::filters(const Setup& setup) {
  constexpr canid_t kKind = CAN_EFF_FLAG | CAN_RTR_FLAG;
  std::vector<can_filter> filters{{kSync, CAN_SFF_MASK | kKind}};
  for (const Wish& wish : setup.nodes) filters.push_back({wish.node, kNodeMask | kKind});
  return filters;
}

void Network::begin(std::int64_t now_ns) {
  delivery_.release();
  outbox_.clear();
  for (Member& member : members_) member.node.reset(now_ns);
}

void Network::hold(dwell_fault fault, const std::string& reason) {
  running_ = window_open_ = sync_returns_ = false;
  outbox_.clear();
  for (Member& member : members_) {
    member.node.rest();
    member.streams.clear();
  }
  delivery_.hold(fault, reason);
}

// ---- frames --------------------------------------------------------------------------------------------------------

void Network::take(const socketcan::Frame& frame, std::int64_t now_ns) {
  const canid_t id = frame.can.can_id;
  if (held() || frame.fd || id > CAN_SFF_MASK) return;
  if (id == kSync) return take_sync(frame);
  Member* const member = by_id_[id & kNodeMask];
  if (member == nullptr || frame.own) return;
  if (id >= kFirstPdo && id <= kLastPdo) return take_answer(*member, frame, now_ns);
  member->node.take(classic(frame.can), now_ns);
  follow(*member);
}

void Network::take_sync(const socketcan::Frame& frame) noexcept {
  if (!frame.own) {
    host_.count(DWELL_FAULT_BAD_FRAME);
    if (!std::exchange(told_foreign_, true))
      host_.log(DWELL_WARNING, setup_.interface + ": somebody else sends SYNC as well; expected it from here alone");
    return;
  }
  sync_returns_ = true;
  // One from before has been given up.
  if (!window_open_ || sync_.returned ||
      (!frame.stamp.replaced && frame.stamp.t_ns + frame.stamp.t_half_ns < sync_.before_ns))
    return;
  sync_.returned = true;
  if (frame.stamp.replaced) return;
  sync_.t_ns = frame.stamp.t_ns;
  sync_.t_half_ns = frame.stamp.t_half_ns;
}

void Network::take_answer(Member& member, const socketcan::Frame& frame, std::int64_t now_ns) noexcept {
  for (Stream& stream : member.streams) {
    if (stream.pdo.id != frame.can.can_id) continue;
    member.node.heard(now_ns);
    const std::int64_t half_ns = frame.stamp.t_half_ns;
    if (!window_open_ || !stream.asked || frame.stamp.t_ns + half_ns < sync_.before_ns) {
      stream.attribution.late();
      return;
    }
    if (frame.stamp.replaced && frame.stamp.t_ns - half_ns < sync_.before_ns) stream.attribution.spoil();
    stream.attribution.answer();
    stream.size = std::min<std::uint8_t>(frame.can.len, CAN_MAX_DLEN);
    std::memcpy(stream.data.data(), frame.can.data, CAN_MAX_DLEN);
    return;
  }
}

// A node that has been started anew has its PDOs as they are now.
void Network::follow(Member& member) {
  if (!member.node.operational()) {
    member.streams.clear();
    return;
  }
  if (member.starts == member.node.starts() && !member.streams.empty()) return;
  member.starts = member.node.starts();
  member.streams.clear();
  for (const Pdo& pdo : member.node.pdos()) {
    member.streams.emplace_back();
    member.streams.back().pdo = pdo;
    member.streams.back().seen_ns = member.node.started_ns();
  }
}

// ---- SYNC ----------------------------------------------------------------------------------------------------------

bool Network::sync_due(std::int64_t now_ns) {
  const bool wanted = !held() && std::any_of(members_.begin(), members_.end(),
                                             [](const Member& member) { return member.node.operational(); });
  if (!wanted) {
    close_window(now_ns);
    running_ = false;
    return false;
  }
  if (!running_) {
    running_ = true;
    next_sync_ns_ = now_ns;
  }
  if (now_ns < next_sync_ns_) return false;
  close_window(now_ns);
  pause_if_needed(now_ns);
  if (now_ns < next_sync_ns_) return false;
  // A deadline more than a period ago is not made up for.
  if (now_ns - next_sync_ns_ >= setup_.period_ns) {
    host_.count(DWELL_FAULT_MISSED_DEADLINE);
    next_sync_ns_ = now_ns - (now_ns - next_sync_ns_) % setup_.period_ns;
  }
  next_sync_ns_ += setup_.period_ns;
  if (now_ns - last_sync_ns_ >= setup_.late_ns)
    for (Member& member : members_)
      for (Stream& stream : member.streams) stream.attribution.forget();
  return true;
}

void Network::sync_sent(std::int64_t before_raw_ns, std::int64_t after_raw_ns, std::int64_t now_ns) noexcept {
  const std::int64_t width_ns = std::max<std::int64_t>(0, after_raw_ns - before_raw_ns);
  sync_ = {before_raw_ns, before_raw_ns + width_ns / 2,
           static_cast<std::uint32_t>(std::min<std::int64_t>(width_ns / 2 + 1, UINT32_MAX)), false};
  last_sync_ns_ = now_ns;
  window_open_ = true;
  sync_failure_.clear();
  for (Member& member : members_) {
    for (Stream& stream : member.streams) {
      stream.attribution.begin();
      stream.asked = true;
    }
  }
}

void Network::sync_failed(const std::string& why) noexcept {
  host_.count(DWELL_FAULT_MISSED_DEADLINE);
  if (sync_failure_.empty()) sync_failure_ = why;
}

// Instead of the SYNC that is due: until nothing older can come any more. What is too slow for the rate has none of it:
// a pause only shows whether it still is.
void Network::pause_if_needed(std::int64_t now_ns) noexcept {
  if (now_ns < next_pause_ns_) return;
  for (const Member& member : members_) {
    for (const Stream& stream : member.streams) {
      if (!stream.attribution.wants_pause()) continue;
      if (stream.told == DWELL_FAULT_LATE_ANSWER && now_ns < next_trial_ns_) continue;
      while (next_sync_ns_ < last_sync_ns_ + setup_.late_ns) next_sync_ns_ += setup_.period_ns;
      next_pause_ns_ = next_sync_ns_ + kBetweenPauses * std::max(setup_.late_ns, setup_.period_ns);
      next_trial_ns_ = next_sync_ns_ + setup_.timeout_ns;
      return;
    }
  }
}

// ---- samples -------------------------------------------------------------------------------------------------------

void Network::close_window(std::int64_t now_ns) noexcept {
  if (!std::exchange(window_open_, false)) return;
  // It has not gone out yet: what came was asked for by nothing that is known.
  const bool unsent = sync_returns_ && !sync_.returned;
  for (Member& member : members_) {
    for (Stream& stream : member.streams) {
      if (!stream.asked) continue;
      if (unsent) stream.attribution.spoil();
      close(member, stream, now_ns);
    }
  }
  delivery_.push();
}

void Network::close(Member& member, Stream& stream, std::int64_t now_ns) noexcept {
  const Attribution::Outcome outcome = stream.attribution.close();
  const unsigned late = stream.attribution.take_late();
  host_.count(DWELL_FAULT_LATE_ANSWER, late);
  if (outcome == Attribution::Outcome::answered) {
    stream.answered = true;
    stream.seen_ns = now_ns;
    stream.told = DWELL_FAULT_NONE;
    member.node.answers(std::all_of(member.streams.begin(), member.streams.end(),
                                    [](const Stream& each) { return each.answered && each.told == DWELL_FAULT_NONE; }));
    deliver(stream, now_ns);
    return;
  }
  if (late > 0) stream.gave_up_ns = now_ns;
  // What comes before its first answer was sent before it had started.
  if (outcome == Attribution::Outcome::missing && stream.answered) host_.count(DWELL_FAULT_TIMEOUT);
  for (const Field& field : stream.pdo.fields) delivery_.lost(field.channel);
}

void Network::deliver(const Stream& stream, std::int64_t now_ns) noexcept {
  for (const Field& field : stream.pdo.fields) {
    const Reading reading = read_value(std::span(stream.data).first(stream.size), field.first_bit, field.type);
    if (reading.verdict == Verdict::value) {
      delivery_.add(field.channel, {sync_.t_ns, sync_.t_half_ns}, reading.value);
      continue;
    }
    const bool is_short = reading.verdict == Verdict::short_frame;
    delivery_.fail(field.channel, is_short ? DWELL_FAULT_SHORT_FRAME : DWELL_FAULT_INVALID_VALUE, now_ns, [&] {
      return setup_.channels[field.channel].source +
             (is_short ? ": its PDO ends before the object" : ": its PDO holds what is not a number");
    });
  }
}

// ---- time ----------------------------------------------------------------------------------------------------------

std::int64_t Network::next_ns(std::int64_t now_ns) const noexcept {
  std::int64_t next_ns = std::max(next_watch_ns_, now_ns);
  if (running_) next_ns = std::min(next_ns, next_sync_ns_);
  if (window_open_) next_ns = std::min(next_ns, last_sync_ns_ + kLongestWindow_ns);
  return next_ns;
}

void Network::tick(std::int64_t now_ns) {
  if (window_open_ && now_ns >= last_sync_ns_ + kLongestWindow_ns) close_window(now_ns);
  if (now_ns < next_watch_ns_) return;
  next_watch_ns_ = now_ns + kWatch_ns;
  if (!held()) watch_silence(now_ns);
}

void Network::watch_silence(std::int64_t now_ns) {
  for (Member& member : members_) {
    member.node.tick(now_ns);
    follow(member);
  }
  for (Member& member : members_)
    if (!member.streams.empty()) watch_streams(member, now_ns);
  for (std::size_t i = 0; i < setup_.channels.size(); ++i) {
    const Node& node = members_[setup_.channels[i].node].node;
    if (node.fault() != DWELL_FAULT_NONE) delivery_.tell(i, node.fault(), node.reason());
  }
}

// A node is set up again only where none of its TPDOs answers: doing it for one would stop the others each time.
void Network::watch_streams(Member& member, std::int64_t now_ns) {
  const auto is_late = [&](const Stream& stream) { return now_ns - stream.gave_up_ns < setup_.timeout_ns; };
  const auto is_overdue = [&](const Stream& stream) { return now_ns - stream.seen_ns >= setup_.timeout_ns; };
  const auto is_silent = [&](const Stream& stream) { return is_overdue(stream) && !is_late(stream); };
  const auto why = [&](const std::string& who) {
    return sync_failure_.empty() ? who + ": no answer to SYNC for " + seconds(setup_.timeout_ns)
                                 : setup_.interface + ": SYNC cannot be sent: " + sync_failure_;
  };
  if (std::all_of(member.streams.begin(), member.streams.end(), is_silent)) {
    member.node.fail(DWELL_FAULT_TIMEOUT, why(member.node.name()), now_ns);
    follow(member);
    return;
  }
  for (Stream& stream : member.streams) {
    if (!is_overdue(stream)) continue;
    const dwell_fault fault = is_late(stream) ? DWELL_FAULT_LATE_ANSWER : DWELL_FAULT_TIMEOUT;
    if (stream.told == fault) continue;
    if (fault == DWELL_FAULT_LATE_ANSWER) {
      // It answers, and setting it up again would not make it faster.
      member.node.answers(false);
      tell(stream, fault,
           member.node.name() + ": its answers are lost, or come later than the next SYNC; expected a lower `rate`");
      continue;
    }
    host_.count(fault);
    tell(stream, fault,
         why(member.node.name() + ": TPDO " + std::to_string(stream.pdo.number) + " (" + hex(stream.pdo.id) + ")"));
  }
}

void Network::tell(Stream& stream, dwell_fault fault, const std::string& reason) noexcept {
  stream.told = fault;
  for (const Field& field : stream.pdo.fields) delivery_.tell(field.channel, fault, reason);
}

}  // namespace dwell::canopen
