// Copies an anchor to a place where the service cannot alter it afterwards: a file, for instance on another computer,
// or a command that sends it away. Both may hang, so call it only on a thread that may wait.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "daemon/record/result.hpp"

namespace dwell::record {

// Time between two anchors if the rig file states none.
inline constexpr double kAnchorMinutes = 10.0;

struct AnchorTarget {
  double minutes = 0.0;              // between two anchors; 0: kAnchorMinutes
  std::string file;                  // lines are added to it; empty: no file
  std::vector<std::string> command;  // program and arguments; empty: none. No shell sees them
};

// Time that a command may take. Doubled, a command that hangs delays the next anchor longer. Halved, a slow network
// fails.
inline constexpr std::chrono::seconds kAnchorCommandLimit{30};

// Adds the lines to the file, if there is one, and then writes them to the standard input of the command, if there is
// one. `lines`: without the last newline; at most 64 KiB, the room of a pipe. Fails with the file or the command and
// the reason, for instance the exit status; if both fail, with the command's. "not done within 30 s": the command and
// all that it started were killed.
[[nodiscard]] Result<void> deliver_anchor(const AnchorTarget& target, const std::string& lines,
                                          std::chrono::milliseconds limit = kAnchorCommandLimit);

}  // namespace dwell::record
