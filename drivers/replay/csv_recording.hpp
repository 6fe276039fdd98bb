// A recording as text: CSV, either wide, `t,y0,y1,…` (seconds, then one column per channel; an empty cell is no
// sample), or long, `t,channel,value` (each sample its own instant). Header-only, so that the replay plugin and the
// command line read the same files in the same way without linking each other.
//
// Tolerated: CRLF, blanks around cells, a UTF-8 byte order mark, blank lines, lines that begin with `#`, a leading `+`.
// Everything else that is not exactly a recording is refused with one line, `FILE:LINE:COLUMN: what, what was expected`
// (columns count bytes from 1): numbers that are not finite, time that does not advance (wide: from row to row; long:
// it may stand but not go back within a channel), missing or surplus cells, names given twice. Fields are not quoted.
#pragma once

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <system_error>
#include <tl/expected.hpp>
#include <unordered_map>
#include <utility>
#include <vector>

namespace dwell {

struct CsvRecording {
  struct Sample {
    double t_s;            // finite, |t_s| <= kCsvLatest
    double value;          // finite
    std::uint16_t column;  // index into channels
  };
  std::vector<std::string> channels;  // wide: in the header's order; long: in the order of appearance
  std::vector<Sample> samples;        // ordered by t_s, then column; at least one
};

inline constexpr std::size_t kCsvMaxChannels = 4096;
inline constexpr std::size_t kCsvMaxLine = 1U << 20U;  // bytes
inline constexpr double kCsvLatest = 9e9;              // s: instants must fit 64 bit of ns

// Reads the file; its size bounds the memory (at most about 12 bytes per byte). Thread-safe; a few 10 ns per sample.
// `go_on` is asked about every MiB; false ends the reading with an error.
[[nodiscard]] inline tl::expected<CsvRecording, std::string> read_csv(const std::string& path,
                                                                      const std::function<bool()>& go_on = {});

// The same from memory; `name` stands for the file in error texts.
[[nodiscard]] inline tl::expected<CsvRecording, std::string> parse_csv(std::string_view text, const std::string& name);

namespace detail {

// Takes one line after the other, then finish(). After the first mistake error() is set and the rest is ignored.
class CsvParser {
 public:
  explicit CsvParser(std::string name) : name_(std::move(name)) {}

  // `line` without its LF. false: stop, there is an error.
  bool line(std::string_view line) {
    ++line_number_;
    if (line.size() > kCsvMaxLine) return fail(line.data(), line.data(), "the line is too long; at most 1 MiB is read");
    if (line_number_ == 1 && line.substr(0, 3) == "\xEF\xBB\xBF") line.remove_prefix(3);
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    const std::string_view text = trimmed(line);
    if (text.empty() || text.front() == '#') return true;
    switch (shape_) {
      case Shape::unknown:
        return header(line);
      case Shape::wide:
        return wide(line);
      case Shape::longer:
        return longer(line);
    }
    return false;
  }

  tl::expected<CsvRecording, std::string> finish() {
    if (error_.empty() && recording_.samples.empty())
      fail(nullptr, nullptr,
           shape_ == Shape::unknown ? "the recording is empty; expected a header `t,NAME,…` or `t,channel,value`"
                                    : "the recording has no samples");
    if (!error_.empty()) return tl::make_unexpected(std::move(error_));
    auto before = [](const CsvRecording::Sample& a, const CsvRecording::Sample& b) {
      return a.t_s != b.t_s ? a.t_s < b.t_s : a.column < b.column;
    };
    auto& samples = recording_.samples;
    if (!std::is_sorted(samples.begin(), samples.end(), before))
      std::stable_sort(samples.begin(), samples.end(), before);
    return std::move(recording_);
  }

  bool fail(const char* line_begin, const char* at, const std::string& message) {
    error_ = name_ + ":" + std::to_string(std::max<std::uint64_t>(line_number_, 1)) + ":" +
             std::to_string(at - line_begin + 1) + ": " + message;
    return false;
  }

 private:
  enum class Shape : std::uint8_t { unknown, wide, longer };

  static std::string_view trimmed(std::string_view text) {
    const auto first = text.find_first_not_of(" \t");
    if (first == std::string_view::npos) return text.substr(text.size());
    return text.substr(first, text.find_last_not_of(" \t") - first + 1);
  }

  // The next cell of `rest`, which then begins behind its comma; more: there is another cell.
  static std::string_view next_cell(std::string_view& rest, bool& more) {
    const auto comma = rest.find(',');
    more = comma != std::string_view::npos;
    const std::string_view cell = rest.substr(0, comma);
    rest.remove_prefix(more ? comma + 1 : rest.size());
    return trimmed(cell);
  }

  // A piece of the file as it may be shown to people.
  static std::string quoted(std::string_view cell) {
    std::string text = "`";
    for (const char c : cell.substr(0, 40)) text += c >= ' ' && c <= '~' ? c : '?';
    return text + (cell.size() > 40 ? "…`" : "`");
  }

  bool header(std::string_view line) {
    std::string_view rest = line;
    bool more = false;
    const std::string_view t = next_cell(rest, more);
    if (t != "t" || !more)
      return fail(line.data(), t.data(),
                  "the header begins with " + quoted(t) + "; expected `t,NAME,…` or `t,channel,value`");
    std::vector<std::string_view> names;
    while (more) {
      const std::string_view name = next_cell(rest, more);
      if (name.empty()) return fail(line.data(), name.data(), "a channel without a name; expected `t,NAME,…`");
      for (const char c : name)
        if (static_cast<unsigned char>(c) < ' ' || c == '\x7F')
          return fail(line.data(), name.data(), "the name " + quoted(name) + " has control characters in it");
      names.push_back(name);
      if (names.size() > kCsvMaxChannels)
        return fail(line.data(), name.data(), "too many columns; at most 4096 channels");
    }
    if (names.size() == 2 && names[0] == "channel" && names[1] == "value") {
      shape_ = Shape::longer;
      return true;
    }
    shape_ = Shape::wide;
    for (const std::string_view name : names)
      if (!column_of(name).second)
        return fail(line.data(), name.data(), "the channel " + quoted(name) + " is there twice");
    return true;
  }

  // The column of a channel, and whether it is new.
  std::pair<std::uint16_t, bool> column_of(std::string_view name) {
    const auto next = static_cast<std::uint16_t>(recording_.channels.size());
    const auto [place, is_new] = columns_.try_emplace(std::string(name), next);
    if (is_new) {
      recording_.channels.emplace_back(name);
      latest_.push_back(-kCsvLatest);
    }
    return {place->second, is_new};
  }

  bool number(std::string_view line, std::string_view cell, const char* what, double& value) {
    const char* first = cell.data();
    const char* const last = cell.data() + cell.size();
    if (cell.size() > 1 && cell[0] == '+' && cell[1] != '-') ++first;
    const auto [end, code] = std::from_chars(first, last, value);
    if (code == std::errc{} && end == last && std::isfinite(value)) return true;
    const bool beyond = code == std::errc::result_out_of_range || (code == std::errc{} && end == last);
    return fail(line.data(), cell.data(),
                std::string(what) + " is " + (cell.empty() ? std::string("missing") : quoted(cell)) + "; expected a " +
                    (beyond ? "finite number" : "number"));
  }

  bool instant(std::string_view line, std::string_view cell, double& t_s) {
    if (!number(line, cell, "t", t_s)) return false;
    if (std::fabs(t_s) <= kCsvLatest) return true;
    return fail(line.data(), cell.data(), "t is " + quoted(cell) + "; expected seconds, at most 9e9");
  }

  bool wide(std::string_view line) {
    std::string_view rest = line;
    bool more = false;
    const std::string_view t = next_cell(rest, more);
    CsvRecording::Sample sample{};
    if (!instant(line, t, sample.t_s)) return false;
    if (has_row_ && !(sample.t_s > row_t_s_))
      return fail(line.data(), t.data(),
                  "t is " + quoted(t) + " and does not advance; expected more than in the row before");
    has_row_ = true;
    row_t_s_ = sample.t_s;
    const std::size_t columns = recording_.channels.size();
    for (std::size_t column = 0; column < columns; ++column) {
      if (!more)
        return fail(
            line.data(), line.data() + line.size(),
            "the row ends after " + std::to_string(column + 1) + " cells; expected " + std::to_string(columns + 1));
      const std::string_view cell = next_cell(rest, more);
      if (cell.empty()) continue;
      if (!number(line, cell, "the value", sample.value)) return false;
      sample.column = static_cast<std::uint16_t>(column);
      recording_.samples.push_back(sample);
    }
    return !more ||
           fail(line.data(), rest.data(), "the row goes on; expected " + std::to_string(columns + 1) + " cells");
  }

  bool longer(std::string_view line) {
    std::string_view rest = line;
    bool more = false;
    const std::string_view t = next_cell(rest, more);
    CsvRecording::Sample sample{};
    if (!instant(line, t, sample.t_s)) return false;
    if (!more) return fail(line.data(), rest.data(), "the row ends after t; expected `t,channel,value`");
    const std::string_view name = next_cell(rest, more);
    if (name.empty())
      return fail(line.data(), name.data(), "the channel's name is missing; expected `t,channel,value`");
    if (!more) return fail(line.data(), rest.data(), "the row ends after the channel; expected `t,channel,value`");
    const std::string_view cell = next_cell(rest, more);
    if (!number(line, cell, "the value", sample.value)) return false;
    if (more) return fail(line.data(), rest.data(), "the row goes on; expected `t,channel,value`");
    // Recordings are mostly cyclic: the channel after the last one is tried before the map.
    const std::size_t guess = previous_ + 1 < recording_.channels.size() ? previous_ + 1 : 0;
    sample.column = guess < recording_.channels.size() && recording_.channels[guess] == name
                        ? static_cast<std::uint16_t>(guess)
                        : column_of(name).first;
    if (recording_.channels.size() > kCsvMaxChannels)
      return fail(line.data(), name.data(), "too many channels; at most 4096");
    if (sample.t_s < latest_[sample.column])
      return fail(
          line.data(), t.data(),
          "t is " + quoted(t) + " and goes back; expected at least that of the sample before of " + quoted(name));
    latest_[sample.column] = sample.t_s;
    previous_ = sample.column;
    recording_.samples.push_back(sample);
    return true;
  }

  std::string name_;
  std::string error_;
  std::uint64_t line_number_ = 0;
  Shape shape_ = Shape::unknown;
  CsvRecording recording_;
  std::unordered_map<std::string, std::uint16_t> columns_;
  std::vector<double> latest_;  // s, per channel
  double row_t_s_ = 0.0;
  bool has_row_ = false;
  std::size_t previous_ = 0;
};

// Hands the whole lines of `text` to the parser and removes them; `last`: what remains is a line as well.
inline bool feed_lines(CsvParser& parser, std::string_view& text, bool last) {
  while (true) {
    const auto end = text.find('\n');
    if (end == std::string_view::npos) break;
    if (!parser.line(text.substr(0, end))) return false;
    text.remove_prefix(end + 1);
  }
  if (!last || text.empty()) return true;
  const std::string_view line = std::exchange(text, {});
  return parser.line(line);
}

}  // namespace detail

inline tl::expected<CsvRecording, std::string> parse_csv(std::string_view text, const std::string& name) {
  detail::CsvParser parser(name);
  detail::feed_lines(parser, text, true);
  return parser.finish();
}

inline tl::expected<CsvRecording, std::string> read_csv(const std::string& path, const std::function<bool()>& go_on) {
  auto failed = [&](int code) {
    return tl::make_unexpected(path + ":1:1: cannot be read: " + std::generic_category().message(code));
  };
  // Without O_NONBLOCK a named pipe would hold up the caller until somebody writes to it.
  const int opened = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
  if (opened < 0) return failed(errno);
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(::fdopen(opened, "rb"), &std::fclose);
  if (!file) return ::close(opened), failed(ENOMEM);
  struct stat status {};
  if (::fstat(opened, &status) != 0) return failed(errno);
  if (!S_ISREG(status.st_mode))
    return tl::make_unexpected(path + ":1:1: is no regular file; expected a recording in a file");
  detail::CsvParser parser(path);
  // Twice the longest line, so that a line which does not end is recognized while memory stays fixed.
  std::vector<char> buffer(2 * kCsvMaxLine);
  std::size_t held = 0;
  bool ended = false;
  while (!ended) {
    if (go_on && !go_on()) return tl::make_unexpected(path + ":1:1: reading was given up");
    const std::size_t got = std::fread(buffer.data() + held, 1, buffer.size() - held, file.get());
    if (got == 0 && std::ferror(file.get()) != 0) return failed(errno);
    ended = got == 0;
    std::string_view text(buffer.data(), held + got);
    if (!detail::feed_lines(parser, text, ended)) break;
    if (text.size() > kCsvMaxLine && !parser.line(text)) break;
    std::copy(text.begin(), text.end(), buffer.begin());
    held = text.size();
  }
  return parser.finish();
}

}  // namespace dwell
