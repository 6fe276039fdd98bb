// The browsers that have shown the token. Each has a random value in a cookie, since a live stream (EventSource) can
// send no header of its own. Kept in memory alone: a restart ends all sessions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace dwell {

// Bound to one thread. The caller gives the instants, which never step back.
class Sessions {
 public:
  // Sessions at a time: the browsers of a rig's operators and its wall displays. One more ends the session that was
  // used least recently. Larger: a script that logs in for each request piles up more. Smaller: operators log each
  // other out.
  static constexpr std::size_t kMost = 32;
  // A session that is not used for so long ends: 12 h, a shift. Shorter: operators must log in amid their work. Longer:
  // a browser left behind may act for longer.
  static constexpr std::int64_t kUnused_ns = std::int64_t{12} * 3600 * 1'000'000'000;
  // An open page uses its session each second. So a session also ends so long after it began: 7 days. Shorter: wall
  // displays ask for the token more often. Longer: a page left open may act for longer.
  static constexpr std::int64_t kLongest_ns = std::int64_t{7} * 24 * 3600 * 1'000'000'000;

  // Begins one and returns its value, 64 hexadecimal digits. Throws where the kernel has no random bytes.
  std::string begin(std::int64_t now_ns);
  // Whether the session goes on. If it does, this is a use of it.
  bool use(std::string_view value, std::int64_t now_ns);
  void end(std::string_view value);
  void end_all();
  // Ends the sessions whose time is over. Returns the values of all that have ended, in any way, since the last call.
  [[nodiscard]] std::vector<std::string> take_ended(std::int64_t now_ns);

  [[nodiscard]] std::size_t count() const noexcept { return open_.size(); }

 private:
  struct Session {
    std::string value;
    std::int64_t begun_ns, used_ns;
  };
  void end_overdue(std::int64_t now_ns);
  void end_at(std::vector<Session>::iterator session);
  [[nodiscard]] std::vector<Session>::iterator find(std::string_view value);

  std::vector<Session> open_;
  std::vector<std::string> ended_;  // values
};

// The value of the named cookie in a request's Cookie field; empty: it is not there. Pure.
[[nodiscard]] std::string_view cookie_value(std::string_view field, std::string_view name);

}  // namespace dwell
