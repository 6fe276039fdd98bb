// The dwells of recorded runs, read from their files: of an earlier run the service itself knows nothing more. No file
// is read on the event loop (HttpReply::later).
//
//   GET /api/v1/runs/FILE/dwells        the newest in short; ?from=INDEX and count=N as for /api/v1/dwells
//   GET /api/v1/runs/FILE/dwells/INDEX  one of them, the whole dwell object
//
// Limits and model have the verdicts of the file. A file may be hostile: how long it is read and how much of it is kept
// have bounds, and what cannot be read is answered with one reason. Whether it was altered is not checked here: the
// audit does that (run_audits.hpp).
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <string_view>

#include "daemon/serve/http_server.hpp"
#include "daemon/service_view.hpp"

namespace dwell {

class RunDwells {
 public:
  // Runs that are remembered once read, until their files change. Each takes up to 4 MB for its dwells, and as
  // much for what is held against them (kBytesOfDwells).
  static constexpr std::size_t kRuns = 4;
  // Dwells of a run that are remembered: its newest, as many as the service keeps of the current run.
  static constexpr std::size_t kDwells = 1000;
  // Reading a file ends after so long. It reads every result: of four elements 0.9 GB for a day's run, 10 s from a slow
  // disk. Longer: one hostile file keeps others waiting for longer.
  static constexpr std::chrono::seconds kReading{60};

  // at_most: for reading one file.
  explicit RunDwells(std::chrono::seconds at_most = kReading);

  // Whether the path is one of the two.
  [[nodiscard]] static bool is_asked(std::string_view path);
  // The answer to such a path, or how it is made later. Bound to the event loop's thread.
  [[nodiscard]] HttpReply answer(const ServiceView& now, std::string_view path, std::string_view query) const;

 private:
  class Reading;
  const std::shared_ptr<Reading> reading_;  // used where late answers are made
};

}  // namespace dwell
