// Whether runs can be recorded, asked of the recording directory now and then, and why not.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "daemon/record/notice.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/run_log.hpp"
#include "daemon/record/utc_text.hpp"

namespace dwell::record {

// Bound to the recorder's thread; virtual time.
class Readiness {
 public:
  // Least time between two new runs that are asked for, since each ends a dwell; and between two tries to open a
  // directory that cannot be used, which may take seconds.
  static constexpr std::int64_t kRetry_ns = 30'000'000'000;
  // Time between two looks once the directory is open: whoever makes room and then starts a run types longer than this.
  // While no run is recorded, a look costs three questions to the file system; else nothing.
  static constexpr std::int64_t kLook_ns = 250'000'000;

  // Folder and log outlive it.
  Readiness(RunFolder& folder, RunLog& log, Tell tell) : folder_(folder), log_(log), tell_(std::move(tell)) {}

  // Asks when it is time to. May wait for the disk. true: a new run should begin, for the current one is not recorded
  // any more, and another could be.
  [[nodiscard]] bool turn(const ClockPair& now) { return now.raw_ns >= next_look_ns_ && look(now); }
  // The same, at once.
  [[nodiscard]] bool look(const ClockPair& now);

  // Whether the directory has been opened.
  [[nodiscard]] bool open() const noexcept { return open_; }
  // Why no run can be recorded, as of the last look; empty: nothing is known that prevents it.
  [[nodiscard]] const std::string& trouble() const noexcept { return trouble_; }
  // Why the current run is not recorded, or none can be, as of now: a run that was stopped keeps the figures of then.
  [[nodiscard]] std::string why_not() const;

 private:
  void healed();
  void opened();

  RunFolder& folder_;
  RunLog& log_;
  const Tell tell_;
  std::string trouble_;
  bool told_trouble_ = false;  // the log says that none can be recorded
  bool open_ = false;
  std::int64_t next_look_ns_ = 0;
  std::optional<std::int64_t> asked_ns_;  // when a new run was asked for last
};

}  // namespace dwell::record
