#include "daemon/ctl/terminal.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <string_view>

namespace dwell::ctl {
namespace {

constexpr std::string_view kEnter = "\x1b[?1049h\x1b[?25l";  // the alternate screen, no cursor
constexpr std::string_view kLeave = "\x1b[0m\x1b[?25h\x1b[?1049l";
constexpr std::array kCrashes{SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};

// For the handler of a crash, which can reach nothing else. Written before the handler is installed.
int crash_keys_fd = -1;
termios crash_settings{};

void restore_settings(int fd, const termios& settings, int when) {
  if (fd >= 0) ::tcsetattr(fd, when, &settings);
}

// Only calls that a signal handler may make.
void on_crash(int signal) {
  const ssize_t ignored = ::write(STDOUT_FILENO, kLeave.data(), kLeave.size());
  (void)ignored;
  restore_settings(crash_keys_fd, crash_settings, TCSANOW);
  ::raise(signal);  // SA_RESETHAND: the default action now
}

void handle_crashes(bool on) {
  struct sigaction action {};
  action.sa_handler = on ? &on_crash : SIG_DFL;
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_NODEFER);
  for (const int signal : kCrashes) ::sigaction(signal, &action, nullptr);
}

void put(std::string_view text) {
  std::fwrite(text.data(), 1, text.size(), stdout);
  std::fflush(stdout);
}

bool set(const char* variable) {
  const char* value = std::getenv(variable);
  return value != nullptr && *value != '\0';
}

std::string_view looks(Style style, bool colour) {
  switch (style) {
    case Style::plain:
      return "";
    case Style::title:
      return "\x1b[1m";
    case Style::old:
      return colour ? "\x1b[90;9m" : "\x1b[2;9m";
    case Style::past:
      return colour ? "\x1b[90m" : "\x1b[2m";
    case Style::tentative:
      return "\x1b[2m";
    case Style::doubted:
      return colour ? "\x1b[33;7m" : "\x1b[7m";
    case Style::alarm:
      return colour ? "\x1b[1;31m" : "\x1b[1;7m";
    case Style::hint:
      return "\x1b[2m";
  }
  return "";
}

Key key_of(char c) {
  switch (c) {
    case ' ':
    case 'p':
      return Key::pause;
    case 'n':
      return Key::next;
    case 'b':
      return Key::back;
    case 'r':
      return Key::rearm;
    case 'q':
      return Key::quit;
    case 'y':
      return Key::yes;
    default:
      return Key::other;
  }
}

}  // namespace

std::vector<Key> keys_in(std::string_view typed) {
  struct Sequence {
    std::string_view bytes;
    Key key;
  };
  // Arrows in both modes of a terminal, page down and up.
  static constexpr std::array<Sequence, 10> sequences{{{"\x1b[C", Key::next},
                                                       {"\x1b[B", Key::next},
                                                       {"\x1bOC", Key::next},
                                                       {"\x1bOB", Key::next},
                                                       {"\x1b[6~", Key::next},
                                                       {"\x1b[D", Key::back},
                                                       {"\x1b[A", Key::back},
                                                       {"\x1bOD", Key::back},
                                                       {"\x1bOA", Key::back},
                                                       {"\x1b[5~", Key::back}}};
  std::vector<Key> keys;
  while (!typed.empty()) {
    if (typed.front() != '\x1b') {
      keys.push_back(key_of(typed.front()));
      typed.remove_prefix(1);
      continue;
    }
    std::size_t used = 0;
    for (const Sequence& sequence : sequences) {
      if (typed.substr(0, sequence.bytes.size()) != sequence.bytes) continue;
      keys.push_back(sequence.key);
      used = sequence.bytes.size();
    }
    // What is not known is dropped to the letter or ~ that ends it: its bytes must not pass as keys.
    if (used == 0) {
      used = 1;
      if (used < typed.size() && (typed[used] == '[' || typed[used] == 'O')) ++used;
      while (used < typed.size() && typed[used] < '@') ++used;
      if (used < typed.size() && used > 1) ++used;
    }
    typed.remove_prefix(used);
  }
  return keys;
}

std::string frame(const std::vector<TextLine>& lines, bool colour) {
  std::string out = "\x1b[H";
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (i > 0) out += "\r\n";
    const std::string_view look = looks(lines[i].style, colour);
    out.append(look).append(lines[i].text).append(look.empty() ? "" : "\x1b[0m").append("\x1b[K");
  }
  return out + "\x1b[J";
}

bool Terminal::there() {
  const char* kind = std::getenv("TERM");
  return ::isatty(STDOUT_FILENO) != 0 && kind != nullptr && *kind != '\0' && std::string_view(kind) != "dumb";
}

Terminal::Terminal() : colour_(!set("NO_COLOR")) {
  keys_fd_ = ::open("/dev/tty", O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (keys_fd_ >= 0 && ::tcgetattr(keys_fd_, &crash_settings) != 0) {
    ::close(keys_fd_);
    keys_fd_ = -1;
  }
  crash_keys_fd = keys_fd_;
  enter();
}

Terminal::~Terminal() {
  leave();
  crash_keys_fd = -1;
  if (keys_fd_ >= 0) ::close(keys_fd_);
}

void Terminal::enter() {
  if (entered_) return;
  entered_ = true;
  handle_crashes(true);
  if (keys_fd_ >= 0) {
    ::tcgetattr(keys_fd_, &crash_settings);
    termios settings = crash_settings;
    settings.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
    settings.c_cc[VMIN] = 1;
    settings.c_cc[VTIME] = 0;
    restore_settings(keys_fd_, settings, TCSADRAIN);
  }
  put(kEnter);
}

void Terminal::leave() {
  if (!entered_) return;
  entered_ = false;
  put(kLeave);
  // Keys that nobody has read must not land in the shell.
  restore_settings(keys_fd_, crash_settings, TCSAFLUSH);
  handle_crashes(false);
}

void Terminal::show(const std::vector<TextLine>& lines) {
  if (entered_) put(frame(lines, colour_));
}

Size Terminal::size() {
  winsize size{};
  const bool known = ::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_row > 0 && size.ws_col > 0;
  return known ? Size{size.ws_row, size.ws_col} : Size{};
}

std::vector<Key> Terminal::keys() {
  std::array<char, 256> typed{};
  const ssize_t got = keys_fd_ < 0 ? 0 : ::read(keys_fd_, typed.data(), typed.size());
  if (got > 0) return keys_in({typed.data(), static_cast<std::size_t>(got)});
  // A terminal that has gone is readable for ever.
  if (keys_fd_ >= 0 && (got == 0 || (errno != EAGAIN && errno != EINTR))) return {Key::quit};
  return {};
}

}  // namespace dwell::ctl
