#include "daemon/ctl/fetch.hpp"

#include <cstdio>

#include "daemon/ctl/http_client.hpp"
#include "daemon/report/number_text.hpp"

namespace dwell::ctl {
namespace {

int unreachable(const std::string& why) {
  std::fprintf(stderr, "dwellctl: %s\n", printable(why).c_str());
  return kUnreachable;
}

}  // namespace

int not_the_service(const std::string& url, const std::string& why) {
  return unreachable(url + ": what answers is not the service: " + why);
}

tl::expected<Json, int> fetch(const Service& service, const std::string& path) {
  const auto url = parse_url(service.url);
  if (!url) {
    std::fprintf(stderr, "dwellctl: %s\n", printable(url.error()).c_str());
    return tl::unexpected(static_cast<int>(kUsage));
  }
  const auto answer = http_get(*url, path);
  if (!answer) return tl::unexpected(unreachable(answer.error()));
  Json value = Json::parse(answer->body, nullptr, false);
  if (answer->status != 200) {
    std::string why = "status " + std::to_string(answer->status);
    if (value.is_object() && value.contains("error") && value["error"].is_string()) {
      why += ", " + value["error"].get<std::string>();
    }
    return tl::unexpected(unreachable(service.url + path + ": " + why));
  }
  if (value.is_discarded()) return tl::unexpected(not_the_service(service.url, "no JSON"));
  return value;
}

}  // namespace dwell::ctl
