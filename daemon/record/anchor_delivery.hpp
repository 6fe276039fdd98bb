// Copies an anchor to a place where the service cannot alter it afterwards: a file, for instance on another computer,
// or a command that sends it away. Both may hang, so call it only on a thread that may wait.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "daemon/record/keys.hpp"

namespace dwell::record {

struct AnchorTarget {
  double minutes = 0.0;              // between two anchors; 0: none are delivered
  std::string file;                  // lines are added to it; empty: no file
  std::vector<std::string> command;  // program and arguments; empty: none. No shell sees them
};

// Time that a command may take. Doubled, a command that hangs delays the next anchor longer. Halved, a slow network
// fails.
inline constexpr std::chrono::seconds kAnchorCommandLimit{30};

// Adds the lines to the file, or writes them to the command's standard input. All lines must fit into a pipe. Fails
// with the file or command and the reason, for instance the exit status. "Not done within 30 s": the command and all
// that it started were killed.
[[nodiscard]] Result<void> deliver_anchor(const AnchorTarget& target, const std::string& lines,
                                          std::chrono::milliseconds limit = kAnchorCommandLimit);

}  // namespace dwell::record
