#include "daemon/run/operator_requests.hpp"

#include <pwd.h>

#include <utility>
#include <vector>

namespace dwell {
namespace {

using Verb = OperatorRequest::Verb;

std::string words(const OperatorRequest& request) {
  switch (request.verb) {
    case Verb::start:
      return "run \"" + request.label + "\" started";
    case Verb::stop:
      return "run stopped";
    case Verb::label:
      return "run labelled \"" + request.label + "\"";
    case Verb::rearm:
      return "dwell re-armed";
    case Verb::acknowledge:
      break;
  }
  return {};
}

// What a re-arm ends, as an auditor wants to know it.
std::string words(const Dwell& dwell) {
  return (dwell.index ? "dwell " + std::to_string(*dwell.index) + ", " : std::string()) + to_string(dwell.state);
}

}  // namespace

std::string user_name(uid_t uid) {
  std::vector<char> room(16 * 1024);
  passwd entry{};
  passwd* found = nullptr;
  if (getpwuid_r(uid, &entry, room.data(), room.size(), &found) != 0 || found == nullptr) return {};
  return found->pw_name;
}

std::string OperatorRequests::obstacle(Verb verb) const {
  if (verb != Verb::label && !run_.has_room()) return "too many at once; try again";
  if (verb == Verb::rearm) return {};
  if (!run_.bracketed())
    return "not recording: the rig file has no [recording], and one run lasts as long as the service";
  if (verb == Verb::start) {
    const record::Obstacle recording = recorder_ == nullptr ? record::Obstacle{} : recorder_->obstacle();
    if (!operators_run_.empty() && recording.why.empty())
      return operators_run_ + " goes on: stop it first, with dwellctl stop";
    if (!operators_run_.empty())
      return recording.of_every_run ? "recording is stopped: " + recording.why + "; once that is mended, " +
                                          operators_run_ + " goes on by itself within 30 s"
                                    : operators_run_ + " waits to go on by itself: " + recording.why;
    if (recording.of_every_run)
      return "recording is stopped: " + recording.why + "; once that is mended, start the run again";
  }
  if (verb == Verb::stop && !run_goes_on()) return "nothing to stop: no run goes on";
  return verb == Verb::label ? obstacle_to_label() : std::string();
}

std::string OperatorRequests::obstacle_to_label() const {
  if (!run_goes_on()) return "nothing to label: no run goes on";
  if (recorder_ == nullptr) return {};
  const record::Obstacle recording = recorder_->obstacle();
  return recording.why.empty() ? std::string() : "the run is not recorded: " + recording.why;
}

bool OperatorRequests::run_goes_on() const { return !operators_run_.empty() || ended_.goes_on(run_.latest().run); }

std::string OperatorRequests::standing() const {
  if (!operators_run_.empty()) return operators_run_;
  return ended_.goes_on(run_.latest().run) ? "a run of the drive" : "no run";
}

tl::expected<void, std::string> OperatorRequests::ask(const OperatorRequest& request, const record::Person& by) {
  run_.refresh();
  if (std::string why = obstacle(request.verb); !why.empty()) return tl::unexpected(std::move(why));
  record::Request told;
  if (request.verb != Verb::label)
    told.number = number_ = number_ == UINT16_MAX ? std::uint16_t{1} : static_cast<std::uint16_t>(number_ + 1);
  told.after = request.verb == Verb::label ? number_ : std::uint16_t{0};
  told.label = request.label;
  told.event.what = "action";
  told.event.text = words(request) + " by " + record::who(by);
  told.event.person = by;
  told.event.comment = request.comment;
  const bool rearms = request.verb == Verb::rearm;
  told.event.before = rearms ? words(run_.latest().dwell) : standing();
  note(request, by);
  told.event.after = rearms ? "a new dwell begins" : request.verb == Verb::stop ? "no run" : standing();
  log_.info(told.event.text + (request.comment.empty() ? "" : ": " + request.comment));
  const std::uint16_t number = told.number;
  if (recorder_ != nullptr) recorder_->request(std::move(told));
  if (request.verb == Verb::start) run_.begin_run(number);
  if (request.verb == Verb::stop) run_.end_run(number);
  if (request.verb == Verb::rearm) run_.rearm(number);
  return {};
}

void OperatorRequests::note(const OperatorRequest& request, const record::Person& by) {
  if (request.verb == Verb::start) {
    started_by_ = record::who(by);
    ended_.started(run_.latest().run);
  }
  if (request.verb == Verb::stop) {
    operators_run_.clear();
    ended_.stopped(run_.latest().run);
  }
  if (request.verb == Verb::start || (request.verb == Verb::label && !operators_run_.empty()))
    operators_run_ = "run \"" + request.label + "\", started by " + started_by_;
}

}  // namespace dwell
