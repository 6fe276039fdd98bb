// What a client asks for, and whether that may be asked at all. Pure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/serve/http_server.hpp"

namespace dwell {

// A request that has been read. The views point into its bytes.
struct HttpRequest {
  enum class Method : std::uint8_t { get, head, post, other };
  Method method = Method::get;
  bool host_needed = true;  // HTTP/1.1
  std::size_t hosts = 1;    // Host fields
  std::string_view host;    // the first of them
  std::string_view target;
  std::string_view known{};  // If-None-Match: tags of answers that the client already holds; empty: none
  std::string_view authorization{}, content_type{}, cookie{}, origin{};  // the fields of these names; empty: none
  std::string_view encodings{};                                          // Accept-Encoding; empty: none
  // Transfer-Encoding: the number of such fields and the value of the first. has_length: there is a Content-Length.
  std::size_t codings = 0;
  std::string_view coding{};
  bool has_length = false;
  std::string_view body{};
  std::string_view from{};     // the client's numeric address
  bool from_loopback = false;  // the client runs on this computer

  // `/api/v1/dwells` and `from=3` of "/api/v1/dwells?from=3".
  [[nodiscard]] std::string_view path() const noexcept { return target.substr(0, target.find('?')); }
  [[nodiscard]] std::string_view query() const noexcept {
    const auto mark = target.find('?');
    return mark == std::string_view::npos ? std::string_view() : target.substr(mark + 1);
  }
};

// Why a request is refused before its path is looked at.
struct HttpRefusal {
  HttpReply reply;
  bool ends = true;  // the connection ends with the refusal
};
// nullopt: it may be answered. names: those of this service, beside numeric addresses and "localhost".
[[nodiscard]] std::optional<HttpRefusal> refusal(const HttpRequest& request, const std::vector<std::string>& names);

// 405. allowed: the methods that the path answers, "GET, HEAD".
[[nodiscard]] HttpReply method_refusal(std::string allowed, std::string_view reason);

// The reply; 304 without a body where the client holds it already, by its tag.
[[nodiscard]] HttpReply unless_known(HttpReply reply, const HttpRequest& request);

}  // namespace dwell
