#include "daemon/outlets/outlet.hpp"

namespace dwell {
namespace {

class Lamps final : public Outlet {
 public:
  explicit Lamps(gpio::Link& lines) : lines_(lines) {}

  void show(const ServiceView& now) override {
    lines_.order({now.health.ready, now.health.status != Health::Status::ok}, now.now_ns);
  }
  void tell(const RunEvent& /*event*/, const Rig& /*rig*/) override {}

 private:
  gpio::Link& lines_;
};

}  // namespace

std::unique_ptr<Outlet> make_lamps(gpio::Link& lines) { return std::make_unique<Lamps>(lines); }

}  // namespace dwell
