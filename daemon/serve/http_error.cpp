#include <nlohmann/json.hpp>

#include "daemon/serve/http_server.hpp"

namespace dwell {

HttpReply http_error(int status, std::string_view reason) {
  HttpReply reply;
  reply.status = status;
  reply.body = nlohmann::json{{"error", reason}, {"status", status}}.dump(-1, ' ', false,
                                                                          nlohmann::json::error_handler_t::replace);
  return reply;
}

}  // namespace dwell
