// Small files of the recording directory, replaced as a whole and durably. Any thread; waits for the disk.
#pragma once

#include <string>
#include <string_view>

#include "daemon/record/result.hpp"

namespace dwell::record {

// The bytes, at most `limit`; fails with the reason.
[[nodiscard]] Result<std::string> read_small_file(const std::string& path, std::size_t limit = 64u << 20);
// Mode 0644 as far as the umask allows. After a loss of power the file holds the old bytes or the new ones.
[[nodiscard]] Result<void> replace_small_file(const std::string& path, std::string_view bytes);
// Appends `line` and a newline, synchronized to the disk. Makes the file if there is none. `line` may hold several
// lines.
[[nodiscard]] Result<void> append_line(const std::string& path, std::string_view line);
// Gives `from` the name `to`. Survives a loss of power.
[[nodiscard]] Result<void> rename_durably(const std::string& from, const std::string& to);

}  // namespace dwell::record
