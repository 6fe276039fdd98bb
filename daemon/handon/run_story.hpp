// The content of a run's report, gathered in one pass over its stream.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "daemon/handon/selection.hpp"
#include "daemon/handon/trace.hpp"
#include "daemon/report/dwell_view.hpp"

namespace dwell::handon {

struct RunStory {
  // Most events, dwells, and estimates with verifications of one report. Those beyond are counted, not shown; the run
  // file has them all.
  static constexpr std::size_t kEvents = 2000;
  static constexpr std::size_t kModels = 1000;
  static constexpr std::size_t kDwells = 500;
  static constexpr std::size_t kUnreadable = 20;  // each at most kEventBytes

  // Bounds of what a report takes from a hostile file, bytes. kEventBytes: each text of an event; a longer one is cut.
  // kStoredBytes: the dwells, estimates and verifications together, as they are stored; what exceeds it is left out and
  // counted.
  static constexpr std::size_t kEventBytes = 2000;
  static constexpr std::size_t kStoredBytes = 64'000'000;

  double begin_s = 0.0, end_s = 0.0;  // on the run's axis
  std::vector<Trace> traces;          // one per channel
  double span_s = 0.0;                // RunReader::span_s(); 0: not known
  std::uint64_t samples = 0;
  std::map<std::pair<std::uint16_t, Loss>, double> lost;     // by channel and why
  std::map<std::pair<std::uint16_t, Fault>, double> faults;  // by device and which
  std::vector<DwellView> dwells;                             // each as it was published last
  std::uint64_t dwells_left_out = 0;
  std::vector<record::StoredModel> models;  // estimates from transients, then verifications
  std::uint64_t models_left_out = 0;
  std::vector<record::StoredEvent> events;
  std::uint64_t events_left_out = 0;
  std::vector<record::PersonalSignature> signatures;
  std::vector<std::string> unreadable;  // why parts of the above are missing or end early; at most kUnreadable
  std::uint64_t unreadable_left_out = 0;
};

// Reads the whole run, or what can be read of it: story.unreadable names the rest. Memory: 10 kB a channel, the dwells
// and events up to their limits.
[[nodiscard]] RunStory tell_run(Selection& selection, const Progress& progress);

}  // namespace dwell::handon
