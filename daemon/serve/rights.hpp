// Who may read and who may change something over HTTP.
//
// Everybody may read where the service listens on loopback or stands behind a front proxy. Elsewhere, clients that come
// over loopback may read; all others need the token. Changing something always needs the token.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "config/rig_file.hpp"
#include "daemon/clock.hpp"
#include "daemon/log/log.hpp"
#include "daemon/log/throttle.hpp"
#include "daemon/serve/http_request.hpp"
#include "daemon/serve/sessions.hpp"
#include "daemon/serve/token.hpp"

namespace dwell {

struct Access {
  bool open = true;            // everybody may read
  std::optional<Token> token;  // none: nothing can be changed over HTTP
  // Name of the cookie of a browser's session. The port belongs to it: browsers do not tell cookies of one host's ports
  // apart, so two services of one computer would end each other's sessions.
  std::string cookie = "dwell";
};

// Reads the token file. Fails where the file cannot be used, or where other computers could read and nothing asks who
// they are; the mistake stands at the key of the rig file that has to change. Not a part of config::load, since an old
// run's rig file must still load where its token is not.
[[nodiscard]] config::Result<Access> read_access(const config::ServerSettings& server);

// The same for the Modbus server, which knows no token: other computers may read only where the rig file says so.
[[nodiscard]] config::Result<void> check_modbus_access(const config::ModbusServerSettings& server);

// Bound to one thread, in dwelld the event loop's.
class Rights {
 public:
  using Clock = std::function<std::int64_t()>;  // ns, never steps back

  // log: gets a line for wrong tokens, one for a burst of them; must outlive this.
  Rights(Access access, Log& log, Clock clock = raw_now_ns)
      : access_(std::move(access)), log_(log), clock_(std::move(clock)) {}

  // Takes the new rights. True: they differ, and every session has ended. False: nothing has changed.
  bool renew(Access access);

  // The refusal with its reason; nullopt: the client may.
  [[nodiscard]] std::optional<HttpReply> reading_refused(const HttpRequest& request);
  [[nodiscard]] std::optional<HttpReply> changing_refused(const HttpRequest& request);
  // login() begins a browser's session; its body is {"token": …}. logout() ends it. Call foreign_refusal() first.
  [[nodiscard]] HttpReply login(const HttpRequest& request);
  [[nodiscard]] HttpReply logout(const HttpRequest& request);
  // The client's session, by its cookie; empty: none. Counts as a use of it.
  [[nodiscard]] std::string session_of(const HttpRequest& request);
  // The sessions that have ended since the last call, as session_of() named them.
  [[nodiscard]] std::vector<std::string> take_ended_sessions() { return sessions_.take_ended(clock_()); }
  // {"read": …, "change": …, "token": …}: what this client may do, and whether there is a token.
  [[nodiscard]] HttpReply told(const HttpRequest& request);

  // Wrong tokens so far.
  [[nodiscard]] std::uint64_t failures() const noexcept { return failures_; }

 private:
  // The client shows the token, or the cookie of a session that was begun with it.
  [[nodiscard]] bool known(const HttpRequest& request);
  [[nodiscard]] bool may_read(const HttpRequest& request);
  void failed(const HttpRequest& request);

  Access access_;
  Sessions sessions_;
  Log& log_;
  const Clock clock_;
  Throttle lines_;
  std::uint64_t failures_ = 0;
};

}  // namespace dwell
