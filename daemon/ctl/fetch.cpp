#include "daemon/ctl/fetch.hpp"

#include <algorithm>
#include <cstdio>
#include <fstream>

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

tl::expected<Url, std::string> url_of(const Service& service) {
  auto url = parse_url(service.url);
  if (!url || service.token_file.empty()) return url;
  std::ifstream file(service.token_file);
  std::getline(file, url->token);
  // What would break the header, or is no token at all.
  const bool fit = std::all_of(url->token.begin(), url->token.end(), [](char c) { return c > ' ' && c < 0x7f; });
  if (url->token.empty() || url->token.size() > 256 || !fit)
    return tl::unexpected(
        "token file " + service.token_file +
        " cannot be used: expected a file that you may read, with one line of at most 256 characters");
  return url;
}

tl::expected<Url, int> usable_url(const Service& service) {
  auto url = url_of(service);
  if (url) return std::move(*url);
  std::fprintf(stderr, "dwellctl: %s\n", printable(url.error()).c_str());
  return tl::unexpected(static_cast<int>(kUsage));
}

tl::expected<Json, int> fetch(const Service& service, const std::string& path) {
  const auto url = usable_url(service);
  return url ? fetch(service, *url, path) : tl::unexpected(url.error());
}

tl::expected<Json, int> fetch(const Service& service, const Url& url, const std::string& path) {
  const auto answer = http_get(url, path);
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
