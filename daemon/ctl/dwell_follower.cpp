#include "daemon/ctl/dwell_follower.hpp"

#include "daemon/report/dwell_change.hpp"

namespace dwell::ctl {

struct DwellFollower::Whole {
  Json dwell;
};

DwellFollower::DwellFollower() : whole_(std::make_unique<Whole>()) {}
DwellFollower::~DwellFollower() = default;

std::optional<std::string> DwellFollower::take(const EventStream::Event& event) {
  if (event.name == "dwell") {
    whole_->dwell = Json::parse(event.data, nullptr, false);
    return event.data;
  }
  if (event.name != "change") return std::nullopt;
  const Json change = Json::parse(event.data, nullptr, false);
  if (!apply_change(whole_->dwell, change)) return std::nullopt;
  return dump(whole_->dwell);
}

}  // namespace dwell::ctl
