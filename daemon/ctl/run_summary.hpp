// A summary of a run without its stream, as a page for people and as JSON. Does not check whether the file was altered:
// `dwellctl audit` does.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "daemon/record/run_entries.hpp"
#include "daemon/report/dwell_view.hpp"

namespace dwell::ctl {

struct RunSummary {
  // Most bytes that each of `dwells`, `models` and `events` keeps: the JSON text of an entry, and what its struct
  // takes. The first entries are kept, those beyond are counted. A day with a fault each second holds 30 MB of events,
  // 1500 dwells hold 30 MB. With twice as much, a hostile file makes `show` take more than 256 MiB; with half, such a
  // day is not shown whole.
  static constexpr std::size_t kListBytes = 32U << 20U;
  static constexpr std::size_t kUnreadable = 20;  // most lines of `unreadable`

  // Entries that exist, and are not in the lists.
  struct LeftOut {
    std::uint64_t dwells = 0, models = 0, events = 0, unreadable = 0;
  };

  std::string file;
  std::uint64_t bytes = 0;  // on the disk, a -wal included
  record::RunHeader header;
  std::string rig;               // its name; empty: this program cannot read the rig file
  std::string key;               // fingerprint
  std::optional<double> span_s;  // from the first to the last entry of the stream; none: it holds nothing
  std::string ended_utc;         // RunReader::ended_utc()
  std::optional<record::RunEnd> end;
  std::vector<DwellView> dwells;            // those that have ended, and one that went on when the record stopped
  std::vector<record::StoredModel> models;  // estimates from transients and verifications, by position
  std::vector<record::StoredEvent> events;
  std::vector<record::PersonalSignature> signatures;
  LeftOut left_out;
  // Which entries cannot be read, and why; one line each. The lists hold the rest.
  std::vector<std::string> unreadable;
};

// Fails with "FILE: what is wrong" where the file cannot be read as a run. Cost: one page of the disk for each second
// of the run. Memory: three times kListBytes, and up to half as much again.
[[nodiscard]] record::Result<RunSummary> read_summary(const std::string& file);

// "closed", or "open": it is being recorded, or was cut off.
[[nodiscard]] const char* state_of(const RunSummary& run) noexcept;

// The page, in lines of at most `columns` characters; only a table that does not fit makes longer ones.
[[nodiscard]] std::string summary_page(const RunSummary& run, std::size_t columns);
// The JSON object, piece by piece: as one value it would take several times the memory of the summary.
void write_summary_json(const RunSummary& run, const std::function<void(const std::string&)>& write);

// "countersigned by the service for anna (uid 1000): Anna Weber: reviewed, 2026-07-01T10:12:03Z". Does not check the
// signature. Who vouches comes first: the person's words could look like that.
[[nodiscard]] std::string signature_text(const record::PersonalSignature& signature);

// "1.2 MB"; powers of ten.
[[nodiscard]] std::string bytes_text(double bytes);
// "79.3 s", "12 min 3 s", "3 h 20 min".
[[nodiscard]] std::string duration_text(double seconds);

}  // namespace dwell::ctl
