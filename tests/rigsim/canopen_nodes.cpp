#include "tests/rigsim/canopen_nodes.hpp"

#include <algorithm>
#include <limits>

#include "drivers/dwell_driver.hpp"
#include "drivers/socketcan/clock_map.hpp"
#include "tests/rigsim/device.hpp"

namespace rigsim {
namespace {

using dwell::driver::monotonic_ns;

constexpr canid_t kSync = 0x80;
// The highest priority is that of NMT: as its data are random, nodes would be stopped and reset by them.
constexpr canid_t kBabble = 0x001;
// A stamp older than that is none.
constexpr std::int64_t kOldest_ns = 1'000'000'000;

}  // namespace

CanopenNodes::CanopenNodes(const Options& options, Responder& responder, const std::function<std::int64_t()>& clock,
                           const SimulatedClock& time)
    : interface_(options.canopen),
      responder_(responder),
      clock_(clock),
      time_(time),
      values_(responder.device.channels().size()),
      trouble_(kBabble, responder.device.faults, options.seed),
      random_(options.seed ^ 0x0CA90CA9ULL) {
  for (std::size_t i = 0; i < values_.size(); ++i) {
    const Transducer what = responder.device.is_force(i) ? Transducer::load_cell
                            : i % 2 == 0                 ? Transducer::encoder
                                                         : Transducer::input;
    members_.push_back({CanopenNode(static_cast<std::uint8_t>(i + 1), what, out_)});
  }
  set_drift(options.clock_drift_ppm);
}

void CanopenNodes::set_drift(double ppm) noexcept {
  for (Member& member : members_) member.node.set_drift(ppm);
}

Result<void> CanopenNodes::open() {
  if (interface_.empty()) return {};
  auto wire = CanWire::open(interface_);
  if (!wire) return tl::make_unexpected(wire.error());
  wire_ = std::move(*wire);
  for (Member& member : members_) member.node.reset(monotonic_ns());
  return {};
}

bool CanopenNodes::happens(double probability) {
  return probability > 0.0 && std::bernoulli_distribution(probability)(random_);
}

void CanopenNodes::watch(std::vector<pollfd>& polled) const {
  if (wire_) wire_->watch(polled);
}

std::optional<std::int64_t> CanopenNodes::next_due_ns() const {
  if (!wire_) return std::nullopt;
  std::int64_t due_ns = std::numeric_limits<std::int64_t>::max();
  for (const Member& member : members_) due_ns = std::min(due_ns, member.node.next_ns());
  for (const Pending& each : pending_) due_ns = std::min(due_ns, each.due_ns);
  if (const auto babble_ns = trouble_.due_ns()) due_ns = std::min(due_ns, *babble_ns);
  return due_ns == std::numeric_limits<std::int64_t>::max() ? std::nullopt : std::optional(due_ns);
}

void CanopenNodes::serve(std::int64_t now_ns) {
  if (!wire_) return;
  received_.clear();
  wire_->receive(received_);
  refused_ += trouble_.babble(*wire_, now_ns);
  for (const WireFrame& frame : received_) take(frame, now_ns);
  for (Member& member : members_) {
    member.node.tick(now_ns);
    collect(member, now_ns);
  }
  send_due(now_ns);
}

void CanopenNodes::take(const WireFrame& frame, std::int64_t now_ns) {
  if (frame.fd || frame.can.can_id > CAN_SFF_MASK) return;
  // What was measured when the frame came, however late this process gets to it.
  std::int64_t age_ns = 0;
  if (frame.real_ns != 0) {
    const auto clocks = dwell::socketcan::read_clocks();
    age_ns = clocks.real_ns - frame.real_ns;
    if (age_ns < 0 || age_ns > kOldest_ns) age_ns = 0;
  }
  const bool sync = frame.can.can_id == kSync;
  const bool asks = frame.can.can_id > 0x600 && frame.can.can_id < 0x680;
  if (sync) ++syncs_;
  if (sync || asks) responder_.device.read(time_.at(clock_() - age_ns), values_);
  ::can_frame classic{};
  classic.can_id = frame.can.can_id;
  classic.can_dlc = std::min<std::uint8_t>(frame.can.len, CAN_MAX_DLEN);
  std::copy_n(frame.can.data, CAN_MAX_DLEN, classic.data);
  for (std::size_t i = 0; i < members_.size(); ++i) {
    Member& member = members_[i];
    if (!member.on) continue;
    if (sync) {
      member.node.sync(values_[i]);
    } else {
      if (asks && classic.can_id == 0x600U + member.node.id()) member.node.set_value(values_[i]);
      member.node.take(classic, now_ns);
    }
    collect(member, now_ns);
  }
}

// What a node has to send, with the faults that befall it on its way; in order.
void CanopenNodes::collect(Member& member, std::int64_t now_ns) {
  const Faults& faults = responder_.device.faults;
  for (::can_frame& frame : out_) {
    if (!member.on || responder_.silent || trouble_.off()) continue;
    if (happens(faults.dropout)) silent_until_ns_ = now_ns + static_cast<std::int64_t>(faults.dropout_length_s * 1e9);
    if (now_ns < silent_until_ns_ || happens(faults.missing)) {
      ++lost_;
      continue;
    }
    if (happens(faults.short_frame)) frame.can_dlc /= 2;
    double delay_s = faults.latency_s;
    if (faults.latency_jitter_s > 0.0)
      delay_s += std::uniform_real_distribution<double>(0.0, faults.latency_jitter_s)(random_);
    if (happens(faults.late)) {
      delay_s += faults.late_by_s;
      ++late_;
    }
    member.last_due_ns = std::max(member.last_due_ns, now_ns + static_cast<std::int64_t>(delay_s * 1e9));
    if (pending_.size() < kMostFrames) pending_.push_back({member.last_due_ns, frame});
  }
  out_.clear();
}

void CanopenNodes::send_due(std::int64_t now_ns) {
  const auto due = [&](const Pending& each) { return each.due_ns <= now_ns; };
  for (const Pending& each : pending_) {
    if (!due(each)) continue;
    WireFrame frame;
    frame.can.can_id = each.frame.can_id;
    frame.can.len = each.frame.can_dlc;
    std::copy_n(each.frame.data, CAN_MAX_DLEN, frame.can.data);
    refused_ += wire_->send(frame);
    ++sent_;
  }
  std::erase_if(pending_, due);
}

CanopenNodes::Member* CanopenNodes::member(const std::string& word) {
  const auto id = number(word);
  for (Member& each : members_)
    if (id && *id == each.node.id()) return &each;
  return nullptr;
}

std::optional<std::string> CanopenNodes::command(const std::vector<std::string>& words) {
  if (interface_.empty()) return std::nullopt;
  if (auto answer = trouble_.command(words, wire_ ? &*wire_ : nullptr)) {
    if (trouble_.off()) pending_.clear();
    return answer;
  }
  const std::string& verb = words[0];
  if (verb == "canopen" && words.size() == 2 && (words[1] == "on" || words[1] == "off")) {
    pending_.clear();
    if (words[1] == "off") wire_.reset();
    if (words[1] == "on" && !wire_) {
      if (auto opened = open(); !opened) return "error: " + opened.error();
    }
    return "ok";
  }
  if (verb != "node-reset" && verb != "emergency" && verb != "mapping" && verb != "node") return std::nullopt;
  Member* const which = words.size() > 1 ? member(words[1]) : nullptr;
  if (verb == "node-reset" && words.size() == 2 && words[1] == "all") {
    for (Member& each : members_) each.node.reset(monotonic_ns());
    return "ok";
  }
  if (which == nullptr) return "error: expected a node, 1 to " + std::to_string(members_.size());
  if (verb == "node-reset" && words.size() == 2) {
    which->node.reset(monotonic_ns());
    return "ok";
  }
  if (verb == "emergency" && words.size() == 3) {
    const auto code = number(words[2]);
    if (!code || *code < 0 || *code > 0xFFFF) return "error: expected: emergency NODE CODE, 0 to 65535";
    which->node.emergency(static_cast<std::uint16_t>(*code), *code < 256 ? 0 : 1);
    collect(*which, monotonic_ns());
    return "ok";
  }
  if (verb == "mapping" && words.size() == 3 && (words[2] == "wrong" || words[2] == "right")) {
    which->node.map_wrongly(words[2] == "wrong");
    which->node.reset(monotonic_ns());
    return "ok";
  }
  if (verb == "node" && words.size() == 3 && (words[2] == "on" || words[2] == "off")) {
    // Power: one that comes back begins anew.
    which->on = words[2] == "on";
    if (which->on) which->node.reset(monotonic_ns());
    return "ok";
  }
  return "error: expected: node-reset NODE|all, emergency NODE CODE, mapping NODE wrong|right, node NODE on|off";
}

std::string CanopenNodes::status() const {
  const auto operational = std::count_if(members_.begin(), members_.end(),
                                         [](const Member& member) { return member.on && member.node.operational(); });
  return "\"nodes\":" + std::to_string(members_.size()) + ",\"nodes_operational\":" + std::to_string(operational) +
         ",\"syncs\":" + std::to_string(syncs_) + ",\"canopen_frames\":" + std::to_string(sent_) +
         ",\"canopen_frames_lost\":" + std::to_string(lost_) + ",\"canopen_frames_late\":" + std::to_string(late_) +
         ",\"canopen_frames_refused\":" + std::to_string(refused_) +
         ",\"canopen_bus_off\":" + (trouble_.off() ? "true" : "false");
}

}  // namespace rigsim
