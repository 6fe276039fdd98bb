#include "daemon/record/anchor.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <optional>
#include <sstream>
#include <string_view>
#include <utility>

#include "daemon/record/bounded_lines.hpp"
#include "daemon/record/utc_text.hpp"

namespace dwell::record {
namespace {

// Of a file of anchors: ten years of two a minute are 2 GB.
constexpr std::size_t kMostBytes = 4'000'000'000;
constexpr std::string_view kMark = "anchor:";  // the first word of the log's line

// Position of the origin, which follows a space; npos: there is none.
std::size_t origin_in(std::string_view line) {
  for (const std::string_view front : {" dwell/run/", " dwell/ledger/"})
    if (const std::size_t at = line.find(front); at != std::string_view::npos) return at + 1;
  return std::string_view::npos;
}

std::vector<std::string> words_of(std::string_view text) {
  std::istringstream stream{std::string(text)};
  return {std::istream_iterator<std::string>(stream), {}};
}

bool holds_only(std::string_view word, std::string_view characters) {
  return !word.empty() && word.find_first_not_of(characters) == std::string_view::npos;
}

// "04:12:17", also with a date, fractions and a zone.
bool is_time(const std::string& word) {
  return holds_only(word, "0123456789-+:.TZ") && std::count(word.begin(), word.end(), ':') >= 2;
}

// "dwelld[12]:", "dwelld@bench.service[12]:".
bool is_tag(const std::string& word) {
  const std::size_t bracket = word.find('[');
  return word.starts_with("dwelld") && bracket != std::string::npos && word.ends_with("]:") &&
         holds_only(std::string_view(word).substr(bracket + 1, word.size() - bracket - 3), "0123456789");
}

// What the log and journalctl write before a message. Words of people follow the beginning of a message of ours, and a
// message is one line. So where nothing else stands before "anchor:", the line is our own. No message of ours may begin
// with words of people.
bool is_front_of_message(const std::vector<std::string>& words) {
  if (words.empty()) return true;                                         // journalctl -o cat
  if (words.size() == 2 && is_time(words[0])) return words[1] == "info";  // the log's file
  const auto time = std::find_if(words.begin(), words.end(), is_time);    // Nov 23 04:12:17
  if (time - words.begin() > 2 || words.end() - time < 3 || !is_tag(words.back())) return false;
  // The host, after the zone where there is one.
  return words.end() - time == 3 ||
         (words.end() - time == 4 && holds_only(time[1], "ABCDEFGHIJKLMNOPQRSTUVWXYZ+-0123456789"));
}

// nullopt: the line is no anchor.
std::optional<Anchor> parse(std::string_view line, std::size_t origin_at) {
  std::vector<std::string> front = words_of(line.substr(0, origin_at));
  const std::vector<std::string> rest = words_of(line.substr(origin_at));
  if (front.empty() || rest.size() != 3) return std::nullopt;
  Anchor anchor{front.back(), rest[0], 0, {}};
  front.pop_back();
  if (!front.empty() && front.back() != kMark) return std::nullopt;
  if (!front.empty()) front.pop_back();
  const auto [end, error] = std::from_chars(rest[1].data(), rest[1].data() + rest[1].size(), anchor.seq);
  const std::optional<std::string> bytes = from_base64(rest[2]);
  if (!is_front_of_message(front) || !parse_utc(anchor.utc) || error != std::errc() ||
      end != rest[1].data() + rest[1].size() || anchor.seq < 1 || !bytes || bytes->size() != anchor.head.size())
    return std::nullopt;
  std::copy(bytes->begin(), bytes->end(), anchor.head.begin());
  return anchor;
}

}  // namespace

std::string to_line(const Anchor& anchor) {
  return anchor.utc + " " + anchor.origin + " " + std::to_string(anchor.seq) + " " +
         base64({reinterpret_cast<const char*>(anchor.head.data()), anchor.head.size()});
}

Result<Anchors> read_anchors(const std::string& path) {
  BoundedLines lines(path, kMostBytes, "anchors");
  if (!lines.is_open() || std::filesystem::is_directory(path))
    return tl::unexpected(path + ": cannot be read: " + std::strerror(lines.is_open() ? EISDIR : errno));
  Anchors anchors;
  for (std::string line; lines.next(line);) {
    const std::size_t at = origin_in(line);
    if (at == std::string::npos) continue;
    if (auto anchor = parse(line, at))
      anchors.all.push_back(std::move(*anchor));
    else
      ++anchors.skipped;
  }
  if (auto ended = lines.ended(); !ended) return tl::unexpected(ended.error());
  if (anchors.all.empty())
    return tl::unexpected(path +
                          ": no anchor in it; expected lines \"UTC dwell/run/ID NUMBER HEAD\", or the output of " +
                          "journalctl -u dwelld");
  return anchors;
}

}  // namespace dwell::record
