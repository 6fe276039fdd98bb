// Brings an anchor to where the service cannot alter it afterwards: a file, for instance on another computer, or a
// command that sends it away. Both may hang: never on a thread that must not wait.
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

// Time that a command may take. Longer: the next anchor waits for one that hangs. Shorter: a slow network is none.
inline constexpr std::chrono::seconds kAnchorCommandLimit{30};

// Adds the lines to the file, gives them to the command's standard input; a few, for they must fit into a pipe. Fails
// with what went wrong: the file, or the command with its exit status or "not done within 30 s", in which case it has
// been killed with all that it started.
[[nodiscard]] Result<void> deliver_anchor(const AnchorTarget& target, const std::string& lines,
                                          std::chrono::milliseconds limit = kAnchorCommandLimit);

}  // namespace dwell::record
