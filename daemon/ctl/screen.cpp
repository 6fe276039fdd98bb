#include "daemon/ctl/screen.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace dwell::ctl {
namespace {

constexpr const char* kEnter = "\x1b[?1049h\x1b[?25l";  // the alternate screen, no cursor
constexpr const char* kLeave = "\x1b[?25h\x1b[?1049l";

// The first `columns` code points of a line.
std::string_view clipped(std::string_view line, std::size_t columns) {
  std::size_t points = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const bool begins = (static_cast<unsigned char>(line[i]) & 0xC0U) != 0x80U;
    if (begins && points++ == columns) return line.substr(0, i);
  }
  return line;
}

}  // namespace

std::string frame(std::string_view text, std::size_t lines, std::size_t columns) {
  std::string out = "\x1b[H";
  for (std::size_t i = 0; i < lines && !text.empty(); ++i) {
    const auto end = std::min(text.find('\n'), text.size());
    if (i > 0) out += "\r\n";
    out.append(clipped(text.substr(0, end), columns)).append("\x1b[K");
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return out + "\x1b[J";
}

Screen::Screen() : in_place_(isatty(STDOUT_FILENO) != 0) {
  if (in_place_) std::fputs(kEnter, stdout);
}

Screen::~Screen() {
  if (in_place_) std::fprintf(stdout, "%s%s", kLeave, last_.c_str());
  std::fflush(stdout);
}

void Screen::show(const std::string& status, const std::string& text) {
  last_ = status + "\n" + text;
  if (in_place_) {
    winsize size{};
    const bool known = ::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_row > 0 && size.ws_col > 0;
    std::fputs(frame(last_, known ? size.ws_row : 24U, known ? size.ws_col : 80U).c_str(), stdout);
  } else {
    std::fprintf(stdout, "%s\n", last_.c_str());
  }
  std::fflush(stdout);
}

}  // namespace dwell::ctl
