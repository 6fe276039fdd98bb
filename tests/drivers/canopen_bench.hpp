// A CANopen bus in virtual time: the plugin's network against rigsim's nodes, frame by frame. CLOCK_MONOTONIC_RAW is
// CLOCK_MONOTONIC plus an offset here, so that one taken for the other shows.
#pragma once

#include <cstring>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "drivers/canopen/network.hpp"
#include "tests/drivers/fake_host.hpp"
#include "tests/durations.hpp"
#include "tests/rigsim/canopen_node.hpp"

namespace dwell::test {

inline constexpr std::int64_t kRawOffset_ns = 777 * kSecond_ns;

class CanopenBench {
 public:
  // What becomes of a frame that a node sends: how much later it comes (ns); none: it is lost.
  using Fate = std::function<std::optional<std::int64_t>(const can_frame& frame)>;
  // The quantity of a node at an instant of CLOCK_MONOTONIC_RAW.
  using Quantity = std::function<double(std::uint8_t node, std::int64_t raw_ns)>;

  static canopen::Setup setup_of(const std::vector<std::pair<std::uint8_t, rigsim::Transducer>>& nodes) {
    canopen::Setup setup;
    setup.interface = "can0";
    for (const auto& [id, what] : nodes) add(setup, id, what);
    return setup;
  }
  static void add(canopen::Setup& setup, std::uint8_t id, rigsim::Transducer what) {
    canopen::Wanted wanted;
    wanted.object = what == rigsim::Transducer::encoder ? canopen::Object{0x6004, 0}
                    : what == rigsim::Transducer::input ? canopen::Object{0x9130, 1}
                                                        : canopen::Object{0x6130, 1};
    wanted.type = *canopen::profile_type(wanted.object.index);
    wanted.channel = setup.channels.size();
    canopen::Wish wish;
    wish.node = id;
    wish.heartbeat_ms = 100;
    wish.window_us = 8000;
    wish.wanted.push_back(wanted);
    setup.channels.push_back({static_cast<std::uint16_t>(10 + setup.channels.size()), "channel", setup.nodes.size()});
    setup.nodes.push_back(wish);
  }

  explicit CanopenBench(const std::vector<std::pair<std::uint8_t, rigsim::Transducer>>& nodes)
      : setup(setup_of(nodes)) {
    for (const auto& [id, what] : nodes) nodes_[id] = std::make_unique<rigsim::CanopenNode>(id, what, out_);
  }

  rigsim::CanopenNode& node(std::uint8_t id) { return *nodes_.at(id); }
  canopen::Network& network() { return *network_; }
  std::int64_t now_ns() const { return now_ns_; }
  // Powers all nodes and begins.
  void start() {
    for (auto& [id, node] : nodes_) {
      node->reset(now_ns_ - rigsim::CanopenNode::kBoot_ns);
      node->tick(now_ns_);
    }
    out_.clear();  // the boot-up messages of long ago
    network_ = std::make_unique<canopen::Network>(setup, driver::Host(*host.host()));
    network_->begin(now_ns_);
  }
  void run_for(std::int64_t span_ns) {
    const std::int64_t end_ns = now_ns_ + span_ns;
    while (now_ns_ < end_ns) step(end_ns);
  }
  // false: not within 20 s.
  bool run_until(const std::function<bool()>& condition) {
    const std::int64_t end_ns = now_ns_ + 20 * kSecond_ns;
    while (!condition() && now_ns_ < end_ns) step(end_ns);
    return condition();
  }
  // A frame that a node sends now, by whatever means.
  void inject(const can_frame& frame) { on_the_way_.emplace(now_ns_ + kWire_ns, frame); }
  bool delivers(std::uint16_t channel) const { return host.state_of(channel).fault == DWELL_FAULT_NONE; }

  canopen::Setup setup;
  FakeHost host;
  Fate fate = [](const can_frame&) { return 0; };
  Quantity quantity = [](std::uint8_t node, std::int64_t) { return 1e-3 * node; };
  bool sync_returns = true;
  bool sync_blocked = false;
  std::vector<std::int64_t> syncs;  // instants, raw
  std::vector<can_frame> sent;      // by the network, SYNC excepted

  static constexpr std::int64_t kWire_ns = 100'000, kAnswer_ns = 300'000;

 private:
  void collect() {
    for (const can_frame& frame : out_)
      if (const auto later_ns = fate(frame)) {
        // What a node sends under one identifier stays in order.
        std::int64_t& at_ns = last_ns_[frame.can_id];
        at_ns = std::max(at_ns, now_ns_ + kAnswer_ns + *later_ns);
        on_the_way_.emplace(at_ns, frame);
      }
    out_.clear();
  }
  void give(const can_frame& frame, bool own) {
    socketcan::Frame received;
    received.can.can_id = frame.can_id;
    received.can.len = frame.can_dlc;
    std::memcpy(received.can.data, frame.data, CAN_MAX_DLEN);
    received.own = own;
    received.stamp = {now_ns_ + kRawOffset_ns, 100, false};
    network_->take(received, now_ns_);
  }
  void send_what_is_pending() {
    while (const can_frame* const frame = network_->outbox().front()) {
      sent.push_back(*frame);
      for (auto& [id, node] : nodes_) node->take(*frame, now_ns_);
      network_->outbox().pop();
      collect();
    }
  }
  void step(std::int64_t end_ns) {
    std::int64_t next_ns = std::min(end_ns, network_->next_ns(now_ns_ + 1));
    for (auto& [id, node] : nodes_) next_ns = std::min(next_ns, node->next_ns());
    if (!on_the_way_.empty()) next_ns = std::min(next_ns, on_the_way_.begin()->first);
    now_ns_ = std::max(now_ns_ + 1, next_ns);
    for (auto& [id, node] : nodes_) node->tick(now_ns_);
    collect();
    while (!on_the_way_.empty() && on_the_way_.begin()->first <= now_ns_) {
      const can_frame frame = on_the_way_.begin()->second;
      on_the_way_.erase(on_the_way_.begin());
      give(frame, false);
    }
    network_->tick(now_ns_);
    send_what_is_pending();
    if (!network_->sync_due(now_ns_)) return;
    if (sync_blocked) {
      network_->sync_failed("No buffer space available");
      return;
    }
    const std::int64_t raw_ns = now_ns_ + kRawOffset_ns;
    network_->sync_sent(raw_ns - 5'000, raw_ns + 5'000, now_ns_);
    if (sync_returns) give(canopen::make_frame(canopen::kSync, {}), true);
    syncs.push_back(raw_ns);
    for (auto& [id, node] : nodes_) node->sync(quantity(id, raw_ns));
    collect();
  }

  std::vector<can_frame> out_;
  std::map<std::uint8_t, std::unique_ptr<rigsim::CanopenNode>> nodes_;
  std::multimap<std::int64_t, can_frame> on_the_way_;
  std::map<canid_t, std::int64_t> last_ns_;
  std::unique_ptr<canopen::Network> network_;
  std::int64_t now_ns_ = 1'000 * kSecond_ns;
};

}  // namespace dwell::test
