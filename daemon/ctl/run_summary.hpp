// A summary of a run without its stream, as a page for people and as JSON. Does not check whether the file was altered:
// `dwellctl audit` does.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "daemon/record/run_entries.hpp"
#include "daemon/report/dwell_view.hpp"

namespace dwell::ctl {

struct RunSummary {
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
};

// Fails with "FILE: what is wrong". Cost: one page of the disk for each second of the run.
[[nodiscard]] record::Result<RunSummary> read_summary(const std::string& file);

// "closed", or "open": it is being recorded, or was cut off.
[[nodiscard]] const char* state_of(const RunSummary& run) noexcept;

// The page, in lines of at most `columns` characters; only a table that does not fit makes longer ones.
[[nodiscard]] std::string summary_page(const RunSummary& run, std::size_t columns);
[[nodiscard]] nlohmann::ordered_json summary_json(const RunSummary& run);

// "countersigned by the service for anna (uid 1000): Anna Weber: reviewed, 2026-07-01T10:12:03Z". Does not check the
// signature. Who vouches comes first: the person's words could look like that.
[[nodiscard]] std::string signature_text(const record::PersonalSignature& signature);

// "1.2 MB"; powers of ten.
[[nodiscard]] std::string bytes_text(double bytes);
// "79.3 s", "12 min 3 s", "3 h 20 min".
[[nodiscard]] std::string duration_text(double seconds);

}  // namespace dwell::ctl
