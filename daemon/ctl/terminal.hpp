// The operator's terminal while watch has it: its alternate screen, no cursor, keys one by one without echo. It comes
// back as it was on every way out that a program has: the destructor, an exception, and the signals of a crash.
//
// Bound to one thread; one at a time.
#pragma once

#include <termios.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "daemon/ctl/watch_page.hpp"

namespace dwell::ctl {

enum class Key : std::uint8_t { pause, next, back, rearm, quit, yes, other };

// What was typed, as keys. Arrows and page keys are sequences of several bytes; a sequence that is not known is no key.
[[nodiscard]] std::vector<Key> keys_in(std::string_view typed);

// The bytes that put the lines onto the screen, from its upper left corner on, and clear what stood there. colour
// false: no colour is used (NO_COLOR); faint, bold, inverse and struck are none. Old numbers are grey, or
// faint, and struck; a result is not struck. What is normal has no colour in either case.
[[nodiscard]] std::string frame(const std::vector<TextLine>& lines, bool colour);

class Terminal {
 public:
  // Whether standard output is a terminal that can be drawn on: not a pipe, and not "dumb".
  [[nodiscard]] static bool there();

  Terminal();
  ~Terminal();
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  // Gives the terminal back for a while (Ctrl-Z), and takes it again.
  void leave();
  void enter();

  void show(const std::vector<TextLine>& lines);
  [[nodiscard]] static Size size();

  // Readable when a key was pressed; -1: no keys can be read.
  [[nodiscard]] int keys_fd() const noexcept { return keys_fd_; }
  [[nodiscard]] std::vector<Key> keys();

 private:
  int keys_fd_ = -1;  // of the controlling terminal: standard input may be something else
  bool colour_;
  bool entered_ = false;
};

}  // namespace dwell::ctl
