// Handles operators' requests: checks whether they can be done now, and writes to the record who asked for what. Every
// request but `label` takes its place in the ordered stream.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>
#include <tl/expected.hpp>

#include "daemon/log/log.hpp"
#include "daemon/record/request.hpp"
#include "daemon/run/ended_runs.hpp"
#include "daemon/run/run.hpp"

namespace dwell {

struct OperatorRequest {
  enum class Verb : std::uint8_t { start, stop, label, rearm, acknowledge };
  Verb verb = Verb::start;
  std::string label;    // of start and label
  std::string comment;  // empty: none
  std::string alarm{};  // of acknowledge: its name
};

// The name that the system knows the user by; empty: none. May wait for another computer, as the system is set up to
// ask (nsswitch.conf).
[[nodiscard]] std::string user_name(uid_t uid);

// Bound to one thread, in dwelld the event loop's.
class OperatorRequests {
 public:
  // Run and log must outlive this. recorder: null, or must outlive it too.
  OperatorRequests(Run& run, Log& log, record::RequestSink* recorder) : run_(run), log_(log), recorder_(recorder) {}

  // A request with a place in the stream enters it within 10 ms. Fails with the reason why it cannot be done. Not for
  // `acknowledge`: that is Alarms::acknowledge().
  tl::expected<void, std::string> ask(const OperatorRequest& request, const record::Person& by);
  // The number of the newest request that has a place in the stream; 0: there was none.
  [[nodiscard]] std::uint16_t newest() const noexcept { return number_; }

 private:
  [[nodiscard]] std::string obstacle(OperatorRequest::Verb verb) const;
  [[nodiscard]] std::string obstacle_to_label() const;
  [[nodiscard]] bool run_goes_on() const;
  // Brings operators_run_ and started_by_ up to date.
  void note(const OperatorRequest& request, const record::Person& by);
  // The state of the run, in words.
  [[nodiscard]] std::string standing() const;

  Run& run_;
  Log& log_;
  record::RequestSink* recorder_;
  std::uint16_t number_ = 0;  // of the newest request
  // The current operator's run and who started it, in words; empty: there is none. Only `stop` ends it, which comes
  // through here too.
  std::string operators_run_, started_by_;
  EndedRuns ended_;
};

}  // namespace dwell
