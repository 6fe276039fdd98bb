// rearm: the operator ends the dwell; the service settles anew and begins the next one.
#include <cstdio>
#include <string>

#include "daemon/ctl/commands.hpp"
#include "daemon/ctl/control_client.hpp"
#include "daemon/report/dwell_json_value.hpp"
#include "daemon/report/number_text.hpp"

namespace dwell::ctl {

tl::expected<std::string, Refusal> ask_to_rearm(const std::string& control_path, std::chrono::milliseconds time) {
  ControlLimits limits;
  limits.time = time;
  auto line = control_exchange(control_path, R"({"verb":"rearm"})", limits);
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

int rearm(const Service& service) {
  const auto answer = ask_to_rearm(service.control, std::chrono::milliseconds(10'000));
  if (!answer) {
    std::fprintf(stderr, "dwellctl: %s\n", printable(answer.error().why).c_str());
    return answer.error().code;
  }
  std::printf("%s\n", service.json ? answer->c_str() : "rearmed: the dwell ends here, and the rig settles anew");
  return kDone;
}

}  // namespace dwell::ctl
