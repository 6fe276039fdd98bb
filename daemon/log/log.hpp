// The service's log: asynchronous, so that no caller ever waits for a disk or a terminal; when lines come faster than
// they can be written the oldest are dropped and counted.
//
// Goes to journald with fields when standard error is connected to it (JOURNAL_STREAM), else to standard error; and to
// a rotating file where one is named. write() is thread-safe, takes a short lock and allocates: never from the sample
// path.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <memory>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>

#include "daemon/log/newest_lines.hpp"

namespace dwell {

// A journald field beside the message, for instance {"DWELL_DEVICE", "amplifier"}.
using LogField = std::pair<std::string_view, std::string_view>;

// The field of a line that tells a change of state: the state that begins.
inline constexpr std::string_view kStateField = "DWELL_STATE";

struct LogOptions {
  std::string file;                          // empty: none
  std::size_t file_bytes = 8 * 1024 * 1024;  // a file is rotated beyond this …
  std::size_t files = 5;                     // … and so many older ones are kept
  std::size_t queue = 8192;                  // lines waiting at most
  bool console = true;                       // journald or standard error
  Level level = Level::info;
};

struct LogStats {
  std::uint64_t lines = 0;    // handed in
  std::uint64_t dropped = 0;  // not written: the queue was full, or the write failed
  bool failing = false;       // the file did not take the newest line …
  std::string reason;         // … for this reason
};

class Log {
 public:
  // Fails, with the reason, when the file cannot be opened.
  static tl::expected<std::unique_ptr<Log>, std::string> make(const LogOptions& options);
  ~Log();  // writes what is waiting
  Log(const Log&) = delete;
  Log& operator=(const Log&) = delete;

  // One line. Control characters in it become spaces: what a device says cannot forge a line.
  void write(Level level, std::string_view message, std::initializer_list<LogField> fields = {}) noexcept;
  void info(std::string_view message, std::initializer_list<LogField> fields = {}) noexcept {
    write(Level::info, message, fields);
  }
  void warning(std::string_view message, std::initializer_list<LogField> fields = {}) noexcept {
    write(Level::warning, message, fields);
  }
  void error(std::string_view message, std::initializer_list<LogField> fields = {}) noexcept {
    write(Level::error, message, fields);
  }

  [[nodiscard]] LogStats stats() const noexcept;
  // What was written last, whatever became of it.
  [[nodiscard]] const NewestLines& newest() const noexcept;

 private:
  struct Impl;
  explicit Log(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

// Whether JOURNAL_STREAM (its value, or null) names the file that `descriptor` is open on.
[[nodiscard]] bool is_journal(const char* journal_stream, int descriptor) noexcept;

}  // namespace dwell
