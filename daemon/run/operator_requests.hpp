// What operators ask for: whether it can be done now, who asks, and what the record is told of it. Every request takes
// its place in the ordered stream.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>
#include <tl/expected.hpp>

#include "daemon/log/log.hpp"
#include "daemon/record/request.hpp"
#include "daemon/run/run.hpp"

namespace dwell {

struct OperatorRequest {
  record::Request::Verb verb = record::Request::Verb::start;
  std::string label;    // of start
  std::string comment;  // empty: none
};

// The name that the system knows the user by; empty: none.
[[nodiscard]] std::string user_name(uid_t uid);

// Bound to one thread, in dwelld the event loop's.
class OperatorRequests {
 public:
  // Run and log must outlive this. recorder: null, or must outlive it too.
  OperatorRequests(Run& run, Log& log, record::RequestSink* recorder) : run_(run), log_(log), recorder_(recorder) {}

  // Enters the stream within 10 ms. Fails with why it cannot be.
  tl::expected<void, std::string> ask(const OperatorRequest& request, const record::Person& by);

 private:
  [[nodiscard]] std::string obstacle(record::Request::Verb verb) const;
  // How the run stands, in words.
  [[nodiscard]] std::string standing() const;

  Run& run_;
  Log& log_;
  record::RequestSink* recorder_;
  std::uint16_t number_ = 0;  // of the newest request
  // The operator's run that goes on, in words; empty: none does. It ends by `stop` alone, which comes by here too.
  std::string operators_run_;
};

}  // namespace dwell
