// Why the current run is not recorded, and what the next recorded run takes over from it: label, comment, and what came
// between.
#pragma once

#include <cstdint>
#include <string>
#include <utility>

namespace dwell::record {

// Bound to one thread. Instants: of the raw clock.
class Interruption {
 public:
  // A run that the drive begins this soon after an interruption counts as the continuation of the last one.
  static constexpr std::int64_t kGoesOn_ns = 60'000'000'000;

  // How the last run was interrupted, in words; the run that goes on says it.
  void interrupted_by(std::string how) { how_ = std::move(how); }
  // Of a run that is interrupted, or could not begin: the one that goes on keeps them.
  void keep_label(std::string label, std::string comment) {
    label_ = std::move(label);
    comment_ = std::move(comment);
  }
  void stopped(std::string why, std::int64_t now_ns) {
    why_ = std::move(why);
    stopped_ns_ = now_ns;
  }
  // A run that begins within kGoesOn_ns from now, and not by an operator, counts as begun by the service.
  void goes_on(std::int64_t now_ns) noexcept { until_ns_ = now_ns + kGoesOn_ns; }
  [[nodiscard]] bool may_go_on(std::int64_t now_ns) const noexcept { return now_ns < until_ns_; }
  // The run that is not recorded has ended.
  void run_ended() noexcept { why_.clear(); }
  // A run is recorded again.
  void over() noexcept { *this = {}; }

  // Why the current run is not recorded (any more); empty: it is, or there is none.
  [[nodiscard]] const std::string& why() const noexcept { return why_; }
  [[nodiscard]] std::int64_t stopped_ns() const noexcept { return stopped_ns_; }
  [[nodiscard]] const std::string& interrupted_by() const noexcept { return how_; }
  [[nodiscard]] const std::string& label() const noexcept { return label_; }
  [[nodiscard]] const std::string& comment() const noexcept { return comment_; }

 private:
  std::string why_, how_, label_, comment_;
  std::int64_t stopped_ns_ = 0, until_ns_ = INT64_MIN;
};

}  // namespace dwell::record
