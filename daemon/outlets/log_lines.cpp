#include "daemon/outlets/outlet.hpp"
#include "daemon/report/dwell_line.hpp"

namespace dwell {
namespace {

class LogLines final : public Outlet {
 public:
  explicit LogLines(Log& log) : log_(log) {}

  void show(const ServiceView& /*now*/) override {}

  void tell(const RunEvent& event, const Rig& rig) override {
    if (event.lost > 0)
      log_.warning(std::to_string(event.lost) + " changes of state or finished dwells are missing here");
    if (event.kind == RunEvent::Kind::dwell_finished) {
      if (event.dwell->doubts.empty())
        log_.info(finished_line(*event.dwell, rig));
      else
        log_.warning(finished_line(*event.dwell, rig));
    } else {
      log_.info(state_line(event.before, *event.dwell), {{kStateField, to_string(event.dwell->state)}});
    }
  }

 private:
  Log& log_;
};

}  // namespace

std::unique_ptr<Outlet> make_log_lines(Log& log) { return std::make_unique<LogLines>(log); }

}  // namespace dwell
