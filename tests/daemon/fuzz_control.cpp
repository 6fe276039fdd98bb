// Whatever lines come over the control socket, each is answered by one line of JSON, and what an operator asks for
// holds no more text than a request may.
#include <nlohmann/json.hpp>
#include <string_view>

#include "daemon/run/countersigner.hpp"
#include "daemon/serve/api.hpp"
#include "tests/daemon/measured_service.hpp"
#include "tests/drivers/fuzz_bytes.hpp"

namespace {

using dwell::test::hold;

void expect_line_of_json(const std::string& answer) {
  hold(answer.find('\n') == std::string::npos && nlohmann::json::accept(answer));
}

void ask(const dwell::ServiceView& view, std::string_view line) {
  if (const auto sign = dwell::parse_sign_request(line, 1000)) {
    if (!*sign) expect_line_of_json(dwell::sign_answer(tl::unexpected(sign->error())));
    return;
  }
  expect_line_of_json(dwell::control_answer(view, line, [](const dwell::OperatorRequest& request) {
    hold(request.label.size() <= 200 && request.comment.size() <= 4000);
    return request.label == "refused" ? tl::expected<void, std::string>(tl::unexpected(request.comment))
                                      : tl::expected<void, std::string>();
  }));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const dwell::test::MeasuredService service;
  const dwell::ServiceView view = service.view();
  std::string_view rest(reinterpret_cast<const char*>(data), size);
  while (!rest.empty()) {
    const std::string_view line = rest.substr(0, rest.find('\n'));
    rest.remove_prefix(std::min(rest.size(), line.size() + 1));
    ask(view, line);
  }
  return 0;
}
