// Puts the events of the live stream together: a `dwell` is the whole object, a `change` what moved since.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "daemon/ctl/http_client.hpp"

namespace dwell::ctl {

class DwellFollower {
 public:
  DwellFollower();
  ~DwellFollower();
  DwellFollower(const DwellFollower&) = delete;
  DwellFollower& operator=(const DwellFollower&) = delete;

  // The whole dwell object as it stands after this event; nullopt: the event tells nothing new of it, or it is a change
  // for which the whole has been missed (the next one comes within a second).
  [[nodiscard]] std::optional<std::string> take(const EventStream::Event& event);

 private:
  struct Whole;
  std::unique_ptr<Whole> whole_;
};

}  // namespace dwell::ctl
