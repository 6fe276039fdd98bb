#include <sys/stat.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <numeric>

#include "drivers/can/dbc.hpp"

namespace dwell::can {
namespace {

DbcResult unreadable(std::string why) { return tl::unexpected(std::vector<DbcMistake>{{1, 1, std::move(why)}}); }

// Insertions, deletions and replacements from one to the other, letters alike in either case.
std::size_t edits(std::string_view a, std::string_view b) {
  const auto lower = [](char c) { return std::tolower(static_cast<unsigned char>(c)); };
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i + 1);
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t same = diagonal + (lower(a[i]) == lower(b[j]) ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({same, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

}  // namespace

DbcResult read_dbc(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return unreadable(std::string("cannot be read: ") + std::strerror(errno));
  // Opening a pipe would wait for its other end.
  if (!S_ISREG(status.st_mode)) return unreadable("is not a file");
  if (static_cast<std::uint64_t>(status.st_size) > kMostDbcBytes)
    return unreadable("the file is too long; expected at most " + std::to_string(kMostDbcBytes >> 20U) + " MiB");
  std::ifstream file(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (!file) return unreadable(std::string("cannot be read: ") + std::strerror(errno));
  return parse_dbc(text);
}

std::string to_string(const std::string& file, const DbcMistake& mistake) {
  return file + ":" + std::to_string(mistake.line) + ":" + std::to_string(mistake.column) + ": " + mistake.text;
}

std::vector<std::string> nearest(std::string_view word, const std::vector<std::string_view>& names, std::size_t most) {
  constexpr std::size_t kLongest = 256;
  std::vector<std::pair<std::size_t, std::string_view>> near;
  if (word.size() > kLongest) return {};
  for (const std::string_view name : names) {
    if (name.size() > kLongest) continue;
    const std::size_t away = edits(word, name);
    if (2 * away <= std::max(word.size(), name.size())) near.emplace_back(away, name);
  }
  std::sort(near.begin(), near.end());
  std::vector<std::string> best;
  for (std::size_t i = 0; i < std::min(most, near.size()); ++i) best.emplace_back(near[i].second);
  return best;
}

}  // namespace dwell::can
