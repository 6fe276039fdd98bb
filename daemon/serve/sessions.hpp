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
  // browser left behind stays in. A page that is open uses it each second.
  static constexpr std::int64_t kUnused_ns = std::int64_t{12} * 3600 * 1'000'000'000;

  // Begins one and returns its value, 64 hexadecimal digits. Throws where the kernel has no random bytes.
  std::string begin(std::int64_t now_ns);
  // Whether it goes on; if so, it has been used.
  bool use(std::string_view value, std::int64_t now_ns);
  void end(std::string_view value);
  void end_all() noexcept { open_.clear(); }

  [[nodiscard]] std::size_t count() const noexcept { return open_.size(); }

 private:
  struct Session {
    std::string value;
    std::int64_t used_ns;
  };
  [[nodiscard]] std::vector<Session>::iterator find(std::string_view value);

  std::vector<Session> open_;
};

// The value of a cookie in a request's Cookie field; empty: it is not there. Pure.
[[nodiscard]] std::string_view cookie_value(std::string_view field, std::string_view name);

}  // namespace dwell
