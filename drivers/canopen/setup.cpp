#include "drivers/canopen/setup.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/canopen/words.hpp"
#include "drivers/socketcan/socket.hpp"

namespace dwell::canopen {
namespace {

using driver::ChannelSettings;
using driver::flag_key;
using driver::integer_key;
using driver::real_key;
using driver::required;
using driver::text_key;

constexpr double kRate_hz = 100.0, kTimeout_s = 1.0, kLate_s = 0.05, kHeartbeat_s = 0.2;
// The part of a period within which a node shall answer; the rest is for what waits on the bus and in the kernel.
constexpr double kWindow = 0.8;
// One that comes more often than it is looked for would not be watched any closer.
constexpr std::int64_t kShortestHeartbeat_ns = kWatch_ns;
constexpr double kMostNumber = 4294967295.0;

constexpr dwell_key kKeys[] = {
    required(text_key(DWELL_DEVICE, "interface", nullptr, "the CAN interface, for instance can0; or unix:PATH")),
    real_key(DWELL_DEVICE, "rate", 0.5, 2000.0, "Hz",
             "SYNCs sent per second, each answered by every node; default 100"),
    flag_key(DWELL_DEVICE, "rate_shift",
             "whether the rate may be shifted by up to 1 %, so that harmonics of the drive do not read as others; "
             "default true"),
    real_key(DWELL_DEVICE, "timeout", 0.05, 60.0, "s", "after which a channel without a sample is stale; default 1"),
    real_key(DWELL_DEVICE, "late", 0.001, 10.0, "s",
             "by which an answer to a SYNC may be late; after one that is missing no SYNC is sent for so long; default "
             "0.05"),
    real_key(DWELL_DEVICE, "heartbeat", 0.0, 65.0, "s",
             "between the heartbeats that nodes shall send, at least 0.01; 0: as they are set; default 0.2"),
    required(integer_key(DWELL_CHANNEL, "node", 1, 127, "", "the node's number on the bus")),
    required(integer_key(DWELL_CHANNEL, "index", 0x1000, 0xFFFF, "", "of the object measured, for instance 0x9130")),
    integer_key(DWELL_CHANNEL, "sub_index", 0, 255, "", "of the object measured; default 0"),
    text_key(DWELL_CHANNEL, "type", kTypeNames, "the object's data type; default as CiA 404 and 406 say of theirs"),
    integer_key(DWELL_CHANNEL, "vendor_id", 0, kMostNumber, "", "that the node must have (1018h:01)"),
    integer_key(DWELL_CHANNEL, "product_code", 0, kMostNumber, "", "that the node must have (1018h:02)"),
    integer_key(DWELL_CHANNEL, "revision", 0, kMostNumber, "", "that the node must have (1018h:03)"),
    integer_key(DWELL_CHANNEL, "serial_number", 0, kMostNumber, "", "that the node must have (1018h:04)"),
};

class SetupReader {
 public:
  SetupReader(const driver::Settings& settings, std::vector<Mistake>& mistakes)
      : settings_(settings), mistakes_(mistakes) {}

  Setup read() {
    setup_.interface = settings_.get<std::string>("interface", "");
    if (const std::string fault = socketcan::interface_fault(setup_.interface); !fault.empty())
      wrong("interface", "`" + setup_.interface + "` " + fault);
    const double period_s = 1.0 / settings_.get<double>("rate", kRate_hz);
    setup_.period_ns = std::llround(1e9 * period_s);
    setup_.timeout_ns = driver::to_ns(settings_.get<double>("timeout", kTimeout_s));
    setup_.late_ns = driver::to_ns(settings_.get<double>("late", kLate_s));
    check_timeout();
    const double heartbeat_s = settings_.get<double>("heartbeat", kHeartbeat_s);
    if (heartbeat_s != 0.0 && driver::to_ns(heartbeat_s) < kShortestHeartbeat_ns)
      wrong("heartbeat", "is too short to be watched; expected 0, or at least " + seconds(kShortestHeartbeat_ns));
    heartbeat_ms_ = static_cast<std::uint16_t>(std::llround(1e3 * heartbeat_s));
    window_us_ = static_cast<std::uint32_t>(std::llround(1e6 * std::min(kWindow * period_s, 1e-9 * kLongestWindow_ns)));
    const auto& channels = settings_.channels();
    for (position_ = 0; position_ < static_cast<int>(channels.size()); ++position_)
      read_channel(channels[static_cast<std::size_t>(position_)]);
    return std::move(setup_);
  }

 private:
  void wrong(const char* key, std::string text) { mistakes_.push_back({position_, key, std::move(text)}); }

  void check_timeout() {
    const std::int64_t gap_ns = longest_gap_ns(setup_);
    if (setup_.timeout_ns > gap_ns) return;
    const char* const remedy = setup_.late_ns > setup_.period_ns ? ", or a shorter `late`" : ", or a higher `rate`";
    wrong("timeout",
          "is no longer than one answer that is lost may leave its channel without a sample; expected more than " +
              seconds(gap_ns) + remedy);
  }

  std::size_t node_of(std::uint8_t id) {
    const auto place =
        std::find_if(setup_.nodes.begin(), setup_.nodes.end(), [&](const Wish& each) { return each.node == id; });
    if (place != setup_.nodes.end()) return static_cast<std::size_t>(place - setup_.nodes.begin());
    Wish wish;
    wish.node = id;
    wish.heartbeat_ms = heartbeat_ms_;
    wish.window_us = window_us_;
    setup_.nodes.push_back(std::move(wish));
    return setup_.nodes.size() - 1;
  }

  void read_channel(const ChannelSettings& channel) {
    Wanted wanted;
    wanted.object = {channel.get<std::uint16_t>("index", 0), channel.get<std::uint8_t>("sub_index", 0)};
    wanted.channel = setup_.channels.size();
    const auto id = channel.get<std::uint8_t>("node", 1);
    const std::size_t node = node_of(id);
    setup_.channels.push_back({channel.index, "node " + std::to_string(id) + ", " + to_string(wanted.object), node});
    read_identity(channel, setup_.nodes[node]);
    const auto name = channel.get<std::string_view>("type");
    const auto type = name ? parse_type(*name) : profile_type(wanted.object.index);
    if (!type) {
      wrong("index",
            "`type` is missing: " + to_string(wanted.object) +
                " is no measured value of CiA 404 or 406, whose data types are known; expected it beside the index");
      return;
    }
    wanted.type = *type;
    Wish& wish = setup_.nodes[node];
    const bool twice = std::any_of(wish.wanted.begin(), wish.wanted.end(),
                                   [&](const Wanted& each) { return each.object == wanted.object; });
    if (twice)
      wrong("index",
            "object " + to_string(wanted.object) + " of node " + std::to_string(id) + " is another channel's already");
    wish.wanted.push_back(wanted);
  }

  void read_identity(const ChannelSettings& channel, Wish& wish) {
    for (std::size_t i = 0; i < wish.identity.size(); ++i) {
      const auto given = channel.get<std::uint32_t>(kIdentityKeys[i]);
      if (given && wish.identity[i] && *given != *wish.identity[i])
        wrong(kIdentityKeys[i], "node " + std::to_string(wish.node) + " has " + hex(*wish.identity[i]) +
                                    " in another channel; expected the same");
      if (given) wish.identity[i] = given;
    }
  }

  const driver::Settings& settings_;
  std::vector<Mistake>& mistakes_;
  Setup setup_;
  int position_ = -1;  // of the channel being read
  std::uint16_t heartbeat_ms_ = 0;
  std::uint32_t window_us_ = 0;
};

}  // namespace

std::span<const dwell_key> keys() noexcept { return kKeys; }

std::int64_t longest_gap_ns(const Setup& setup) noexcept {
  const std::int64_t pause_ns = std::max(setup.late_ns, setup.period_ns);
  return (kBetweenPauses + 2) * pause_ns + 3 * setup.period_ns;
}

Setup read_setup(const driver::Settings& settings, std::vector<Mistake>& mistakes) {
  return SetupReader(settings, mistakes).read();
}

Setup read_setup(const driver::Settings& settings) {
  std::vector<Mistake> mistakes;
  Setup setup = read_setup(settings, mistakes);
  socketcan::refuse(mistakes);
  return setup;
}

}  // namespace dwell::canopen
