// Owns the service's alarms: follows the health, takes acknowledgements, and tells every change to the log and to the
// file of the run.
#pragma once

#include <functional>
#include <string>
#include <tl/expected.hpp>

#include "daemon/alarms/alarm_list.hpp"
#include "daemon/log/log.hpp"
#include "daemon/record/run_entries.hpp"

namespace dwell {

// Bound to one thread, in dwelld the event loop's.
class Alarms {
 public:
  // Puts an event into the file of the run, if there is one.
  using Store = std::function<void(record::StoredEvent)>;

  // The log must outlive this.
  Alarms(Log& log, Store store) : log_(log), store_(std::move(store)) {}

  // To be called with each judged health, at least once a second.
  void look(const Health& health, const record::ClockPair& now);
  // comment: empty: none. Fails with the reason why there is nothing to acknowledge.
  tl::expected<void, std::string> acknowledge(const std::string& name, const std::string& comment,
                                              const record::Person& by, const record::ClockPair& now);

  [[nodiscard]] const AlarmList& list() const noexcept { return list_; }

 private:
  void tell(const AlarmChange& change);

  Log& log_;
  const Store store_;
  AlarmList list_;
};

}  // namespace dwell
