// What dm-log-writes has logged of a block device: the writes in the order in which they became lasting, and marks.
//
// The target logs a write once a flush has made it lasting, not when it was made: before a mark stand the writes that a
// flush had covered by then, behind it up to the next flush those that were under way. Linux,
// Documentation/admin-guide/device-mapper/log-writes.rst.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <tl/expected.hpp>

namespace dwell::record {

// Writes `text` into the log of the device-mapper device `name`. Fails with the reason; root alone may.
[[nodiscard]] tl::expected<void, std::string> mark_block_log(const std::string& name, const std::string& text);

struct LoggedWrite {
  std::uint64_t offset = 0;     // bytes from the device's start
  std::span<const char> bytes;  // of a discard none
  bool lasting = false;         // before the mark
};

// Every write before the mark, then those that were under way, in their order. Fails where there is no such log or
// mark.
[[nodiscard]] tl::expected<void, std::string> read_block_log(const std::string& log, const std::string& mark,
                                                             const std::function<void(const LoggedWrite&)>& take);

}  // namespace dwell::record
