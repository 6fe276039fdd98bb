#include "drivers/canopen/node.hpp"

#include <algorithm>

#include "drivers/canopen/words.hpp"

namespace dwell::canopen {
namespace {

// Devices boot within a second; one that sends no boot-up message is asked all the same.
constexpr std::int64_t kBoot_ns = 1'000'000'000;
// Heartbeats that may be missed before a node counts as silent.
constexpr std::int64_t kHeartbeats = 3;
// A heartbeat that was on its way while the node was started.
constexpr std::int64_t kGrace_ns = 250'000'000;
// Between attempts at a node that was silent and shows signs of life.
constexpr std::int64_t kBetweenAttempts_ns = 500'000'000;

}  // namespace

Node::Node(const Wish& wish, const driver::Host& host, Outbox& outbox)
    : id_(wish.node), host_(host), outbox_(outbox), configurator_(wish), sdo_(wish.node) {}

void Node::reset(std::int64_t now_ns) {
  sdo_.cancel();
  outbox_.push(nmt_frame(Command::reset_communication, id_));
  phase_ = Phase::booting;
  deadline_ns_ = now_ns + kBoot_ns;
}

void Node::rest() noexcept {
  sdo_.cancel();
  phase_ = Phase::resting;
  fault_ = DWELL_FAULT_NONE;
  backoff_.reset();
}

void Node::configure(std::int64_t now_ns) {
  outbox_.push(nmt_frame(Command::pre_operational, id_));
  phase_ = Phase::configuring;
  sdo_.cancel();
  configurator_.begin();
  go_on(now_ns);
}

// Hands answers and requests between the two until one is to be waited for.
void Node::go_on(std::int64_t now_ns) {
  while (phase_ == Phase::configuring && sdo_.state() != SdoClient::State::busy) {
    switch (sdo_.state()) {
      case SdoClient::State::idle:
        break;
      case SdoClient::State::done:
        configurator_.answer({std::nullopt, sdo_.data()});
        break;
      case SdoClient::State::aborted:
        configurator_.answer({sdo_.abort_code(), {}});
        break;
      case SdoClient::State::no_answer:
        return fail(DWELL_FAULT_TIMEOUT, name() + ": no answer when asked for " + to_string(sdo_.object()), now_ns);
      case SdoClient::State::busy:
        break;
    }
    sdo_.cancel();
    if (!configurator_.failure().empty()) return fail(DWELL_FAULT_EXCEPTION, configurator_.failure(), now_ns);
    const Request* const request = configurator_.request();
    if (request == nullptr) return start(now_ns);
    if (request->value)
      sdo_.download(request->object, *request->value, request->size, now_ns);
    else
      sdo_.upload(request->object, now_ns);
  }
  flush();
}

void Node::flush() {
  while (const auto frame = sdo_.to_send()) outbox_.push(*frame);
  host_.count(DWELL_FAULT_LATE_ANSWER, sdo_.take_late());
}

void Node::start(std::int64_t now_ns) {
  outbox_.push(nmt_frame(Command::start, id_));
  phase_ = Phase::operational;
  ++starts_;
  started_ns_ = life_ns_ = now_ns;
  if (!start_line_.due(now_ns)) return;
  std::string text = name() + ": started; measured by";
  for (const Pdo& pdo : pdos())
    text += (&pdo == &pdos().front() ? " TPDO " : ", TPDO ") + std::to_string(pdo.number) + " (" + hex(pdo.id) + ")";
  if (configurator_.heartbeat_ms() == 0) text += "; it sends no heartbeat";
  host_.log(DWELL_INFO, text);
}

void Node::set_fault(dwell_fault fault, const std::string& reason) {
  host_.count(fault);
  fault_ = fault;
  reason_ = reason;
}

void Node::warn(std::int64_t now_ns) {
  if (state_line_.due(now_ns)) host_.log(DWELL_WARNING, reason_);
}

void Node::fail(dwell_fault fault, const std::string& what, std::int64_t now_ns) {
  flush();
  sdo_.cancel();
  set_fault(fault, what);
  phase_ = Phase::failed;
  failed_ns_ = now_ns;
  deadline_ns_ = now_ns + backoff_.next_ns();
}

void Node::take(const can_frame& frame, std::int64_t now_ns) {
  const canid_t id = frame.can_id;
  if (id == kSdoAnswer + id_) {
    sdo_.take(frame, now_ns);
    flush();
    go_on(now_ns);
  } else if (id == kHeartbeat + id_ && frame.can_dlc >= 1) {
    take_state(frame.data[0], now_ns);
  } else if (id == kEmergency + id_ && frame.can_dlc >= 3) {
    take_emergency(frame, now_ns);
  }
}

void Node::take_state(std::uint8_t byte, std::int64_t now_ns) {
  const std::uint8_t state = byte & 0x7FU;
  life_ns_ = now_ns;
  if (phase_ == Phase::resting) return;
  if (state == static_cast<std::uint8_t>(Nmt::boot_up)) {
    if (phase_ == Phase::configuring || phase_ == Phase::operational) {
      set_fault(DWELL_FAULT_DISCONNECTED, name() + ": it has restarted, and is set up again");
      warn(now_ns);
    }
    configure(now_ns);
  } else if (phase_ == Phase::operational && state != static_cast<std::uint8_t>(Nmt::operational) &&
             now_ns - started_ns_ > kGrace_ns) {
    fail(DWELL_FAULT_DISCONNECTED, name() + ": it was started, and is " + state_text(state), now_ns);
    warn(now_ns);
  } else if (phase_ == Phase::failed && fault_ == DWELL_FAULT_TIMEOUT) {
    // It was silent, and is not any more.
    deadline_ns_ = std::min(deadline_ns_, std::max(now_ns, failed_ns_ + kBetweenAttempts_ns));
  }
}

void Node::take_emergency(const can_frame& frame, std::int64_t now_ns) {
  const auto code = static_cast<std::uint16_t>(get_le({frame.data, 2}));
  const bool over = (code & 0xFF00U) == 0;
  if (!over) host_.count(DWELL_FAULT_EXCEPTION);
  if (!emergency_line_.due(now_ns)) {
    ++unsaid_;
    return;
  }
  std::string text = name() + ": emergency " + emergency_text(code) + ", error register " +
                     error_register_text(frame.data[2]) + ", manufacturer's bytes";
  for (unsigned i = 3; i < frame.can_dlc; ++i) text += " " + hex(frame.data[i]);
  if (unsaid_ > 0) text += "; " + std::to_string(unsaid_) + " others since the last line";
  host_.log(over ? DWELL_INFO : DWELL_WARNING, text);
  unsaid_ = 0;
}

void Node::answers(bool all) noexcept {
  fault_ = DWELL_FAULT_NONE;
  if (all) backoff_.reset();
}

void Node::tick(std::int64_t now_ns) {
  switch (phase_) {
    case Phase::resting:
      return;
    case Phase::booting:
      if (now_ns >= deadline_ns_) configure(now_ns);
      return;
    case Phase::configuring:
      sdo_.tick(now_ns);
      flush();
      go_on(now_ns);
      return;
    case Phase::operational: {
      const std::int64_t longest_ns = kHeartbeats * 1'000'000 * configurator_.heartbeat_ms();
      if (longest_ns > 0 && now_ns - life_ns_ > longest_ns) {
        fail(DWELL_FAULT_TIMEOUT, name() + ": no heartbeat for " + seconds(longest_ns), now_ns);
        warn(now_ns);
      }
      return;
    }
    case Phase::failed:
      // What is wrong with its dictionary is not mended by a reset.
      if (now_ns < deadline_ns_) return;
      if (fault_ == DWELL_FAULT_EXCEPTION)
        configure(now_ns);
      else
        reset(now_ns);
      return;
  }
}

}  // namespace dwell::canopen
