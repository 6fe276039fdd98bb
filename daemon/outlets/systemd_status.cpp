#include <cmath>
#include <cstdio>

#include "daemon/notifier.hpp"
#include "daemon/outlets/outlet.hpp"

namespace dwell {
namespace {

std::string status_line(const ServiceView& now) {
  if (now.health.status == Health::Status::fault) return "not working: " + reason_of(now.health);
  const Dwell& dwell = now.snapshot.dwell;
  std::string line = to_string(dwell.state);
  if (dwell.index) line += ", dwell " + std::to_string(*dwell.index);
  if (dwell.state == State::measuring && std::isfinite(dwell.frequency_hz.value)) {
    char text[48];
    std::snprintf(text, sizeof text, ", %.4g Hz", dwell.frequency_hz.value);
    line += text;
  }
  if (now.health.status != Health::Status::ok) line += "; " + reason_of(now.health);
  return line;
}

class SystemdStatus final : public Outlet {
 public:
  explicit SystemdStatus(Notifier& notifier) : notifier_(notifier) {}

  void show(const ServiceView& now) override { notifier_.status(status_line(now)); }
  void tell(const RunEvent& /*event*/, const Rig& /*rig*/) override {}

 private:
  Notifier& notifier_;
};

}  // namespace

std::unique_ptr<Outlet> make_systemd_status(Notifier& notifier) { return std::make_unique<SystemdStatus>(notifier); }

}  // namespace dwell
