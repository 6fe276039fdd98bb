// The canopen plugin's keys, and what they mean as plain values.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "drivers/canopen/configurator.hpp"
#include "drivers/dwell_driver.hpp"
#include "drivers/socketcan/mistake.hpp"

namespace dwell::canopen {

// How often it is looked who has fallen silent.
inline constexpr std::int64_t kWatch_ns = 10'000'000;
// Answers to a SYNC are awaited no longer, however far away the next one is.
inline constexpr std::int64_t kLongestWindow_ns = 50'000'000;
// A node that loses its answers again and again shall not cost the others more than a quarter of the SYNCs: after a
// pause they are sent for so many times its length.
inline constexpr std::int64_t kBetweenPauses = 3;

struct Channel {
  std::uint16_t index = 0;  // dwell_sample::channel
  std::string source;       // for people: "node 5, 9130h:01"
  std::size_t node = 0;     // position in Setup::nodes
};

struct Setup {
  std::string interface;
  std::int64_t period_ns = 10'000'000;      // between SYNCs
  std::int64_t timeout_ns = 1'000'000'000;  // a channel without a sample for so long is stale
  std::int64_t late_ns = 50'000'000;        // an answer to a SYNC comes at most so late
  std::vector<Channel> channels;            // Wanted::channel counts these
  std::vector<Wish> nodes;
};

// For so long at most a channel is without a sample when one of its answers is lost: if it is the first one after a
// pause for another node, the doubt lasts until the end of the next pause. One SYNC in it may come late.
[[nodiscard]] std::int64_t longest_gap_ns(const Setup& setup) noexcept;

using socketcan::Mistake;

[[nodiscard]] std::span<const dwell_key> keys() noexcept;

// Of what has a mistake nothing can be used; every mistake is told.
[[nodiscard]] Setup read_setup(const driver::Settings& settings, std::vector<Mistake>& mistakes);

// The same; throws the first mistake.
[[nodiscard]] Setup read_setup(const driver::Settings& settings);

}  // namespace dwell::canopen
