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
  // Letters of a line; what a longer one holds beyond is left out.
  static constexpr std::size_t kLine = 4096;

  // most: bytes of the whole file.
  BoundedLines(const std::string& path, std::size_t most) : path_(path), file_(path, std::ios::binary), left_(most) {}

  [[nodiscard]] bool is_open() const { return file_.is_open(); }
  // The next line without its end; false: there is none, or the file has more bytes than allowed.
  [[nodiscard]] bool next(std::string& line) {
    line.clear();
    bool any = false;
    for (bool whole = false; !whole && left_ > 0;) {
      file_.getline(part_.data(), static_cast<std::streamsize>(part_.size()));
      const auto count = static_cast<std::size_t>(file_.gcount());
      if (count == 0) break;
      any = true;
      left_ -= std::min(count, left_);
      whole = !file_.fail() && !file_.eof();
      const std::size_t letters = count - (whole ? 1 : 0);
      line.append(part_.data(), std::min(letters, kLine - line.size()));
      if (file_.fail() && !file_.eof()) file_.clear();
    }
    return any && left_ > 0;
  }
  // After next() has returned false: fails if the file was too large to be read.
  [[nodiscard]] Result<void> whole() const {
    if (left_ > 0) return {};
    return tl::unexpected(path_ + ": is too large to be what is expected there");
  }

 private:
  const std::string path_;
  std::ifstream file_;
  std::size_t left_;
  std::array<char, 1024> part_{};
};

}  // namespace dwell::record
