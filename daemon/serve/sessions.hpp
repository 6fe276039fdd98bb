// The browsers that have shown the token: each has a random value in a cookie, since a live stream (EventSource) sends
// no header of its own. In memory alone: a restart ends them all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace dwell {

// Bound to one thread. The caller brings the instants, which never step back.
class Sessions {
 public:
  // Browsers at a time, of a rig's operators and wall displays; one more ends the session that was used least recently.
  // More would only let a script that logs in for each request pile them up.
  static constexpr std::size_t kMost = 32;
  // A session ends when unused for so long, 12 h: a shift. Shorter, and operators log in at their work; longer, and a
  // browser left behind stays in.
  static constexpr std::int64_t kUnused_ns = std::int64_t{12} * 3600 * 1'000'000'000;
  // A page that is open uses its session each second. So it ends so long after its beginning all the same, 7 days.
  // Shorter, and wall displays ask for the token more often; longer, and so long a page that was left open may act.
  static constexpr std::int64_t kLongest_ns = std::int64_t{7} * 24 * 3600 * 1'000'000'000;

  // Begins one and returns its value, 64 hexadecimal digits. Throws where the kernel has no random bytes.
  std::string begin(std::int64_t now_ns);
  // Whether it goes on; if so, it has been used.
  bool use(std::string_view value, std::int64_t now_ns);
  void end(std::string_view value);
  void end_all();
  // Ends those whose time is over. The values of all that have ended, in whatever way, since the last call.
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

// The value of a cookie in a request's Cookie field; empty: it is not there. Pure.
[[nodiscard]] std::string_view cookie_value(std::string_view field, std::string_view name);

}  // namespace dwell
