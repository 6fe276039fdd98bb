// A text that is shown again and again: in place on a terminal, one below the other elsewhere.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace dwell::ctl {

// The text cut to so many lines and columns, each line ending with the sequence that clears what stood behind it.
[[nodiscard]] std::string frame(std::string_view text, std::size_t lines, std::size_t columns);

// Bound to one thread. On a terminal the operator's screen comes back, with the last text on it, when this ends.
class Screen {
 public:
  Screen();
  ~Screen();
  Screen(const Screen&) = delete;
  Screen& operator=(const Screen&) = delete;

  [[nodiscard]] bool in_place() const noexcept { return in_place_; }

  // `status`: one line, shown above the text. Fits both to the terminal as large as it is now.
  void show(const std::string& status, const std::string& text);

 private:
  bool in_place_;
  std::string last_;
};

}  // namespace dwell::ctl
