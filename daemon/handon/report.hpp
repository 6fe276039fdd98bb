// The report of a run: one HTML page for print and archive. It needs no script and no other file; A4 in print, with
// page numbers where the browser knows margin boxes (Chromium 131 and later).
#pragma once

#include <string>
#include <vector>

#include "daemon/handon/output_file.hpp"
#include "daemon/handon/run_story.hpp"
#include "daemon/handon/selection.hpp"

namespace dwell::handon {

// Writes the page. audit: a fresh one of the same file. Returns which parts of the run cannot be read: the page names
// them and holds the rest. Fails with "PATH: why"; then there is no file.
[[nodiscard]] Result<std::vector<std::string>> export_report(Selection& selection, const record::Audit& audit,
                                                             const Provenance& provenance, const Target& target,
                                                             const Progress& progress);

// The parts of the page; each is complete HTML.
[[nodiscard]] std::string report_page(const Selection& selection, const RunStory& story, const record::Audit& audit,
                                      const Provenance& provenance);
// Conditions, rig, channels.
[[nodiscard]] std::string report_conditions(const Selection& selection);
[[nodiscard]] std::string report_channels(const Selection& selection, const RunStory& story);
// What is missing in the stream, and what happened.
[[nodiscard]] std::string report_losses(const Selection& selection, const RunStory& story);
// Estimates from transients, and verifications, as published; empty: there are none.
[[nodiscard]] std::string report_models(const RunStory& story);
[[nodiscard]] std::string report_events(const RunStory& story);
// Audit, hashes, signatures.
[[nodiscard]] std::string report_audit(const Selection& selection, const RunStory& story, const record::Audit& audit);

}  // namespace dwell::handon
