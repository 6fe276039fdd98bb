// One question to the service over HTTP. Heavy: include it in .cpp only.
#pragma once

#include <string>
#include <tl/expected.hpp>

#include "daemon/ctl/commands.hpp"
#include "daemon/ctl/http_client.hpp"
#include "daemon/report/dwell_json_value.hpp"

namespace dwell::ctl {

// The service's address, with the token from the token file; fails with what was expected.
[[nodiscard]] tl::expected<Url, std::string> url_of(const Service& service);

// The same; or an exit code, with the reason on standard error. The token file is read once by each call: it may be a
// pipe.
[[nodiscard]] tl::expected<Url, int> usable_url(const Service& service);

// The document at `path`, asked at usable_url(); or an exit code, with the reason on standard error.
[[nodiscard]] tl::expected<Json, int> fetch(const Service& service, const std::string& path);
[[nodiscard]] tl::expected<Json, int> fetch(const Service& service, const Url& url, const std::string& path);

// Says on standard error that the answer of `url` is not the service's, and why. Returns the exit code.
[[nodiscard]] int not_the_service(const std::string& url, const std::string& why);

}  // namespace dwell::ctl
