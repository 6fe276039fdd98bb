// start, stop, label, rearm and acknowledge: what an operator asks of the service. start, stop and rearm enter the
// service's stream at its place there, with the name of the user who asked.
#include <cstdio>
#include <string>

#include "daemon/ctl/commands.hpp"
#include "daemon/ctl/control_client.hpp"
#include "daemon/report/dwell_json_value.hpp"
#include "daemon/report/number_text.hpp"

namespace dwell::ctl {
namespace {

Json request(const char* verb, const std::string& comment) {
  Json asked{{"verb", verb}};
  if (!comment.empty()) asked["comment"] = comment;
  return asked;
}

tl::expected<std::string, Refusal> ask(const std::string& control_path, const Json& asked,
                                       std::chrono::milliseconds time) {
  ControlLimits limits;
  limits.time = time;
  auto line = control_exchange(control_path, dump(asked), limits);
  if (!line) return tl::unexpected(Refusal{kUnreachable, line.error()});
  const Json answer = Json::parse(*line, nullptr, false);
  const auto error = answer.is_object() ? answer.find("error") : answer.end();
  if (error != answer.end() && error->is_string()) {
    return tl::unexpected(Refusal{kNo, control_path + ": " + error->get<std::string>()});
  }
  const auto done = answer.is_object() ? answer.find("done") : answer.end();
  if (done == answer.end() || *done != true) {
    return tl::unexpected(Refusal{kUnreachable, control_path + ": what answers is not the service"});
  }
  return std::move(*line);
}

// unknown: said in place of `done` where the service does not know whether a run is recorded.
int say(const Service& service, const Json& asked, const std::string& done, const std::string& unknown = {}) {
  const auto answer = ask(service.control, asked, std::chrono::milliseconds(10'000));
  if (!answer) {
    std::fprintf(stderr, "dwellctl: %s\n", printable(answer.error().why).c_str());
    return answer.error().code;
  }
  const bool known = !Json::parse(*answer, nullptr, false).contains("recording");
  std::printf("%s\n", service.json ? answer->c_str() : printable(known ? done : unknown).c_str());
  return kDone;
}

}  // namespace

tl::expected<std::string, Refusal> ask_to_rearm(const std::string& control_path, std::chrono::milliseconds time) {
  return ask(control_path, request("rearm", {}), time);
}

int rearm(const Service& service, const std::string& comment) {
  return say(service, request("rearm", comment), "rearmed: the dwell ends here, and the rig settles anew");
}

int start_run(const Service& service, const std::string& label, const std::string& comment) {
  Json asked = request("start", comment);
  asked["label"] = label;
  return say(service, asked, "started: run \"" + label + "\" begins here and ends with \"dwellctl stop\"",
             "asked: run \"" + label + "\"; whether it is recorded is not known yet, \"dwellctl status\" says it");
}

int label_run(const Service& service, const std::string& label, const std::string& comment) {
  Json asked = request("label", comment);
  asked["label"] = label;
  return say(service, asked, "labelled: the run is \"" + label + "\"");
}

int stop_run(const Service& service, const std::string& comment) {
  return say(service, request("stop", comment), "stopped: the run ends here");
}

int acknowledge(const Service& service, const std::vector<std::string>& names, const std::string& comment) {
  for (const std::string& name : names) {
    Json asked = request("acknowledge", comment);
    asked["alarm"] = name;
    if (const int code = say(service, asked, "acknowledged: " + name); code != kDone) return code;
  }
  return kDone;
}

}  // namespace dwell::ctl
