// Who may read and who may change something over HTTP.
//
// Reading is open to whoever listens on loopback or comes over it, and to everybody behind a front proxy. All others
// need the token to read. Changing something always needs the token.
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
  // Of a browser's session. Cookies know no ports: two services of one computer would end each other's sessions.
  std::string cookie = "dwell";
};

// Reads the token file. Fails where that cannot be used, and where the network could read without anybody asking who it
// is: at the key of the rig file that has to change. Not a part of config::load: an old run's rig file is still to be
// replayed where its token is not.
[[nodiscard]] config::Result<Access> read_access(const config::ServerSettings& server);

// The same of the address for PLCs, which nobody is asked at: the network reads there only where the rig file says so.
[[nodiscard]] config::Result<void> check_modbus_access(const config::ModbusServerSettings& server);

// Bound to one thread, in dwelld the event loop's.
class Rights {
 public:
  using Clock = std::function<std::int64_t()>;  // ns, never steps back

  // log: gets a line for wrong tokens, one for many; must outlive this.
  Rights(Access access, Log& log, Clock clock = raw_now_ns)
      : access_(std::move(access)), log_(log), clock_(std::move(clock)) {}

  // Another token counts from now on, and every session ends. False: it is the same, and they go on.
  bool renew(Access access);

  // Why the client may not; nothing: it may.
  [[nodiscard]] std::optional<HttpReply> reading_refused(const HttpRequest& request);
  [[nodiscard]] std::optional<HttpReply> changing_refused(const HttpRequest& request);
  // A browser's session begins with {"token": …} as the body, and ends. Both are changing requests in all else.
  [[nodiscard]] HttpReply login(const HttpRequest& request);
  [[nodiscard]] HttpReply logout(const HttpRequest& request);
  // The session that the client's reading rests on; empty: none.
  [[nodiscard]] std::string session_of(const HttpRequest& request);
  // The sessions that have ended since the last call, as session_of told them: logged out, overdue, or made room.
  [[nodiscard]] std::vector<std::string> take_ended_sessions() { return sessions_.take_ended(clock_()); }
  // {"read": …, "change": …, "token": …}: what this client may, and whether a token would help.
  [[nodiscard]] HttpReply told(const HttpRequest& request);

  // Wrong tokens so far.
  [[nodiscard]] std::uint64_t failures() const noexcept { return failures_; }

 private:
  // Shows the token, or a session that was begun with it.
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
