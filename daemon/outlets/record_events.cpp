#include "daemon/outlets/outlet.hpp"
#include "daemon/record/recorder.hpp"
#include "daemon/report/dwell_line.hpp"

namespace dwell {
namespace {

// Finished dwells are no events here: they are stored as results.
class RecordEvents final : public Outlet {
 public:
  explicit RecordEvents(record::Recorder& recorder) : recorder_(recorder) {}

  void show(const ServiceView& /*now*/) override {}

  void tell(const RunEvent& event, const Rig& /*rig*/) override {
    if (event.lost > 0)
      store("loss", std::to_string(event.lost) + " changes of state or finished dwells are missing here");
    if (event.kind == RunEvent::Kind::state_changed) store("state", state_line(event.before, *event.dwell));
  }

 private:
  void store(const char* what, std::string text) {
    record::StoredEvent event;
    event.what = what;
    event.text = std::move(text);
    recorder_.event(std::move(event));
  }

  record::Recorder& recorder_;
};

}  // namespace

std::unique_ptr<Outlet> make_record_events(record::Recorder& recorder) {
  return std::make_unique<RecordEvents>(recorder);
}

}  // namespace dwell
