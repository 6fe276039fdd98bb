// The lines of a text file from outside, whatever it is: a file without an end, or one long line, takes no memory.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <fstream>
#include <string>

#include "daemon/record/result.hpp"

namespace dwell::record {

// Bound to one thread. A pipe without a writer is waited for.
class BoundedLines {
 public:
  // Letters of a line. Of a longer one the rest is left out, and cut() says so.
  static constexpr std::size_t kLine = 4096;

  // most: bytes of the file. what: what is expected in it, for messages: "anchors".
  BoundedLines(const std::string& path, std::size_t most, const char* what)
      : path_(path), most_(most), what_(what), file_(path, std::ios::binary), left_(most) {}

  [[nodiscard]] bool is_open() const { return file_.is_open(); }
  // The next line without its newline; false: there is none, the file cannot be read, or it has more than `most` bytes.
  [[nodiscard]] bool next(std::string& line) {
    line.clear();
    cut_ = false;
    for (bool any = false, whole = false; !whole; any = true) {
      file_.getline(part_.data(), static_cast<std::streamsize>(part_.size()));
      const auto count = static_cast<std::size_t>(file_.gcount());
      failed_ = failed_ || file_.bad();
      if (failed_) return false;
      if (count == 0) return any;
      too_large_ = count > left_;
      if (too_large_) return false;
      left_ -= count;
      whole = !file_.fail() && !file_.eof();
      const std::size_t letters = count - (whole ? 1 : 0), fit = std::min(letters, kLine - line.size());
      line.append(part_.data(), fit);
      cut_ = cut_ || fit < letters;
      if (file_.eof()) return true;
      if (!whole) file_.clear();
    }
    return true;
  }
  // Whether the line was longer.
  [[nodiscard]] bool cut() const noexcept { return cut_; }
  // After next() has returned false: fails if that was not the end of the file.
  [[nodiscard]] Result<void> ended() const {
    if (failed_) return tl::unexpected(path_ + ": cannot be read to its end");
    if (!too_large_) return {};
    return tl::unexpected(path_ + ": has more than " + std::to_string(most_) + " bytes; expected a file of " + what_);
  }

 private:
  const std::string path_;
  const std::size_t most_;
  const char* const what_;
  std::ifstream file_;
  std::size_t left_;
  bool cut_ = false, failed_ = false, too_large_ = false;
  std::array<char, 1024> part_{};
};

}  // namespace dwell::record
