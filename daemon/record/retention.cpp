#include "daemon/record/retention.hpp"

#include <cstdio>
#include <cstdlib>

namespace dwell::record {
namespace {

constexpr double kDay_ns = 86'400e9;

std::string limit_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

bool may_go(const ListedRun& run) { return !run.kept && (run.state == "closed" || run.state == "cut off"); }

bool is_older(const ListedRun& run, double days, std::int64_t now_utc_ns) {
  if (!run.clock_synchronized) return false;
  const auto ended_ns = parse_utc(run.ended_utc);
  return ended_ns && static_cast<double>(now_utc_ns - *ended_ns) > days * kDay_ns;
}

}  // namespace

std::string AgeDoubt::at(const ClockPair& now, bool synchronized) {
  if (before_ && std::abs((now.utc_ns - before_->utc_ns) - (now.raw_ns - before_->raw_ns)) >= kStep_ns)
    set_ns_ = now.raw_ns;
  before_ = now;
  if (!synchronized) return "the computer's clock is not synchronized";
  if (set_ns_ && now.raw_ns - *set_ns_ < kAfterStep_ns) return "the computer's clock was set within the last day";
  return {};
}

std::vector<Deletion> choose_deletions(const ListedRuns& runs, const RetentionPolicy& policy, std::int64_t now_utc_ns) {
  double left = 0.0;  // bytes of the runs that stay
  std::vector<Deletion> chosen;
  std::vector<const ListedRun*> others;
  for (const ListedRun& run : runs) {
    if (policy.days && may_go(run) && is_older(run, *policy.days, now_utc_ns)) {
      chosen.push_back({run, "older than " + limit_text(*policy.days) + " days", true});
      continue;
    }
    left += static_cast<double>(run.bytes);
    others.push_back(&run);
  }
  for (const ListedRun* run : others) {
    if (!policy.gigabytes || left <= *policy.gigabytes * 1e9) break;
    if (!may_go(*run)) continue;
    left -= static_cast<double>(run->bytes);
    chosen.push_back({*run, "all runs together were larger than " + limit_text(*policy.gigabytes) + " GB", false});
  }
  return chosen;
}

}  // namespace dwell::record
