// Which runs operators have ended, ahead of the snapshot that shows it: a request takes 10 ms to its place in the
// stream.
#pragma once

#include <algorithm>
#include <cstdint>

#include "daemon/estimate/snapshot.hpp"

namespace dwell {

// Pure. `seen`: the run as the newest snapshot shows it.
class EndedRuns {
 public:
  // An operator's run begins: it has the next number.
  void started(const RunView& seen) noexcept { newest_ = std::max(newest_, seen.number) + 1; }
  // The run that goes on ends.
  void stopped(const RunView& seen) noexcept { ended_ = newest_ = std::max(newest_, seen.number); }
  // Whether a run goes on that nobody has stopped.
  [[nodiscard]] bool goes_on(const RunView& seen) const noexcept { return seen.on && seen.number > ended_; }

 private:
  std::uint32_t newest_ = 0;  // the newest run that is known to begin
  std::uint32_t ended_ = 0;   // no run up to this one goes on
};

}  // namespace dwell
