// The can plugin's keys, and what they mean as plain values.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "drivers/can/decoder.hpp"
#include "drivers/dwell_driver.hpp"
#include "drivers/socketcan/mistake.hpp"

namespace dwell::can {

// What one channel wants, beside where it is found.
struct Channel {
  std::uint16_t index = 0;      // dwell_sample::channel
  std::string source;           // for people: "LoadCell.Force (id 0x123)"
  std::int64_t timeout_ns = 0;  // it is stale after so long without a frame
};

struct Setup {
  std::string interface;
  bool hardware_stamps = true;
  std::vector<Channel> channels;
  std::vector<Wanted> wanted;  // of each channel, in the same order
};

using socketcan::Mistake;

[[nodiscard]] std::span<const dwell_key> keys() noexcept;

// Reads the DBC file if there is one. Of what has a mistake nothing can be used; every mistake is told.
[[nodiscard]] Setup read_setup(const driver::Settings& settings, std::vector<Mistake>& mistakes);

// The same; throws the first mistake.
[[nodiscard]] Setup read_setup(const driver::Settings& settings);

}  // namespace dwell::can
