// Which of a line's edges count. The first edge counts at its own instant; for `debounce` after it the line may bounce
// as it likes, and where it stands then counts. So neither the loss of the interlock nor a pulse is told late, and none
// is told twice. Pure: instants on any one axis.
#pragma once

#include <cstdint>

#include "daemon/gpio/line.hpp"

namespace dwell::gpio {

class EdgeFilter {
 public:
  EdgeFilter(bool level, std::int64_t debounce_ns) noexcept : debounce_ns_(debounce_ns), level_(level), line_(level) {}

  // Calls tell(t_ns, level) for every change that counts, in order: first what was due before the edge. An edge to the
  // level at which the line stands already says that it has been away in between: both changes are told.
  template <class Tell>
  void edge(const LineEdge& edge, Tell&& tell) {
    due(edge.t_ns, tell);
    line_ = edge.level;
    if (edge.t_ns < quiet_until_ns_) {
      ++bounces_;
      return;
    }
    if (edge.level == level_) tell(edge.t_ns, !level_);
    level_ = edge.level;
    quiet_until_ns_ = edge.t_ns + debounce_ns_;
    tell(edge.t_ns, level_);
  }

  // Time has come to t_ns: where the line stands after bouncing counts.
  template <class Tell>
  void due(std::int64_t t_ns, Tell&& tell) {
    if (line_ == level_ || t_ns < quiet_until_ns_) return;
    level_ = line_;
    tell(quiet_until_ns_, level_);
    quiet_until_ns_ += debounce_ns_;
  }

  [[nodiscard]] bool level() const noexcept { return level_; }  // as it counts
  [[nodiscard]] bool line() const noexcept { return line_; }    // after the last edge
  [[nodiscard]] std::uint64_t bounces() const noexcept { return bounces_; }

 private:
  std::int64_t debounce_ns_;
  std::int64_t quiet_until_ns_ = INT64_MIN;
  bool level_;
  bool line_;
  std::uint64_t bounces_ = 0;
};

}  // namespace dwell::gpio
