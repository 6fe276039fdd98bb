#include "daemon/handon/report.hpp"

#include <cctype>
#include <cmath>

#include "daemon/handon/html.hpp"
#include "daemon/handon/output_file.hpp"
#include "daemon/handon/picture.hpp"
#include "daemon/handon/report_dwell.hpp"
#include "daemon/report/number_text.hpp"

namespace dwell::handon {
namespace {

constexpr std::size_t kTraces = 64;  // more would fill a book; the run file has them all

constexpr const char* kStyle = R"(
@page { size: A4; margin: 18mm 16mm 18mm 18mm;
  @bottom-right { content: "page " counter(page) " of " counter(pages); font: 8pt sans-serif; color: #444; } }
:root { --ink: #16202c; --soft: #5a6675; --line: #c9d0d8; --good: #1d6b3a; --bad: #a31621; --open: #8a5a00; }
* { box-sizing: border-box; }
body { font: 10pt/1.42 "Liberation Sans", "DejaVu Sans", Arial, sans-serif; color: var(--ink); margin: 0 auto; max-width: 176mm; padding: 8mm 0; }
@media print { body { padding: 0; max-width: none; } }
h1 { font-size: 19pt; line-height: 1.2; margin: 0 0 1mm; }
h2 { font-size: 13pt; margin: 8mm 0 2mm; border-bottom: 0.4mm solid var(--ink); padding-bottom: 0.8mm; }
h3 { font-size: 11.5pt; margin: 6mm 0 2mm; }
h4 { font-size: 10pt; margin: 4mm 0 1.5mm; }
h1, h2, h3, h4, figcaption { break-after: avoid; }
p { margin: 0 0 2mm; }
.lead { color: var(--soft); margin-bottom: 4mm; }
table { border-collapse: collapse; width: 100%; margin: 0 0 3mm; font-size: 8.6pt; line-height: 1.32; }
thead { display: table-header-group; }
tr { break-inside: avoid; }
th, td { text-align: left; vertical-align: top; padding: 0.9mm 2mm 0.9mm 0; border-bottom: 0.2mm solid var(--line); overflow-wrap: anywhere; }
thead th { color: var(--soft); font-weight: 600; border-bottom-color: var(--soft); overflow-wrap: normal; }
th.whole, td.whole { white-space: nowrap; overflow-wrap: normal; }
th.number, td.number { text-align: right; white-space: nowrap; font-variant-numeric: tabular-nums; padding: 0.9mm 2mm 0.9mm 2mm; }
th.number { white-space: normal; }
.coefficients table { font-size: 8.2pt; }
.coefficients th:first-child, .coefficients th:last-child { width: 1mm; }
.coefficients td.number { white-space: normal; }
.coefficients th.number, .coefficients td.number { padding-left: 1mm; padding-right: 1mm; }
.facts th { width: 38mm; font-weight: 400; color: var(--soft); }
code, pre { font-family: "DejaVu Sans Mono", "Liberation Mono", monospace; font-size: 7.6pt; overflow-wrap: anywhere; }
pre { white-space: pre-wrap; margin: 0; padding: 2mm 3mm; border: 0.2mm solid var(--line); }
ul { margin: 0 0 3mm; padding-left: 4.5mm; }
ul.notes { font-size: 8.6pt; color: var(--soft); }
ul.alarm, strong.alarm, .state.tampered { color: var(--bad); }
ul.alarm { font-weight: 600; }
ul.warning { color: var(--open); }
.state { font-weight: 700; padding: 2mm 3mm; border: 0.5mm solid currentColor; margin: 0 0 4mm; overflow-wrap: anywhere; }
.state.intact { color: var(--good); } .state.open { color: var(--open); }
figure { margin: 0 0 3mm; break-inside: avoid; }
figcaption { font-size: 8.6pt; color: var(--soft); }
.trace figcaption { color: var(--ink); font-weight: 600; }
.beside { display: flex; flex-wrap: wrap; gap: 0 4mm; align-items: flex-start; }
.beside figure { flex: 0 0 74mm; }
.beside div { flex: 1 1 90mm; min-width: min-content; }
.beside td:last-child { overflow-wrap: break-word; }
svg { display: block; max-width: 100%; height: auto; }
svg text { font: 9.5px "Liberation Sans", "DejaVu Sans", Arial, sans-serif; fill: var(--soft); }
svg text.label { fill: var(--ink); font-weight: 600; }
svg text.over { paint-order: stroke; stroke: #fff; stroke-width: 3px; stroke-linejoin: round; }
.frame { fill: none; stroke: var(--soft); stroke-width: 0.8; }
.grid { fill: none; stroke: var(--line); stroke-width: 0.6; }
.shaded { fill: #dfe8f2; }
.trace path { fill: #24527a; stroke: #24527a; stroke-width: 0.8; stroke-linejoin: round; stroke-linecap: round; }
.spring { fill: none; stroke: var(--ink); stroke-width: 1.1; }
.mass { fill: #fff; stroke: var(--ink); stroke-width: 1.3; }
.fixed { fill: #e3e7ec; stroke: var(--ink); stroke-width: 1.3; }
.arrow { stroke-width: 1.7; stroke-linecap: round; fill: none; }
.leader { stroke: var(--line); stroke-width: 0.7; }
.g0 { stroke: #24527a; } .g1 { stroke: #a3441b; stroke-dasharray: 7 3; } .g2 { stroke: #1d6b3a; stroke-dasharray: 2 3; } .g3 { stroke: #6b3a83; stroke-dasharray: 9 2 2 2; }
.arrow.head { stroke-dasharray: none; }
.sign { display: grid; grid-template-columns: 1fr 1fr 1fr; gap: 8mm; margin-top: 18mm; break-inside: avoid; }
.sign div { border-top: 0.3mm solid var(--ink); padding-top: 1mm; font-size: 8.6pt; color: var(--soft); }
)";

const char* state_class(const record::Audit& audit) {
  if (!audit.broken_ledger.empty()) return "tampered";
  switch (audit.state) {
    case record::AuditState::intact:
      return audit.trusted ? "intact" : "open";
    case record::AuditState::open:
      return "open";
    case record::AuditState::tampered:
      return "tampered";
  }
  return "tampered";
}

std::string title_of(const Selection& selection) {
  const record::RunHeader& run = selection.header();
  const std::string number = selection.header().is_child() ? "Child file of run " + run.parent_id.substr(0, 8)
                             : run.run > 0                 ? "Run " + std::to_string(run.run)
                                                           : "Run " + run.id.substr(0, 8);
  return run.label.empty() ? number : number + ": " + run.label;
}

// The foot of each page. Holds hexadecimal digits only, so it cannot end the style sheet.
std::string page_foot(const Selection& selection, const record::Audit& audit) {
  const auto digits = [](const std::string& text, std::size_t most) {
    std::string clean;
    for (const char c : text)
      if (std::isxdigit(static_cast<unsigned char>(c)) != 0 && clean.size() < most) clean += c;
    return clean;
  };
  return "@page { @bottom-left { content: \"run " + digits(selection.header().id, 32) + ", head " +
         digits(audit.head, 16) + "\"; font: 8pt sans-serif; color: #444; } }\n";
}

// The stream's end, so that begun + duration = ended. The `end` entry is written later.
std::string ended_text(const Selection& selection) {
  const auto& end = selection.end();
  if (!end) return "not closed: still recorded, or cut off";
  if (selection.header().is_child()) return "";
  return selection.ended_utc() + ": " + end->why;
}

std::string front(const Selection& selection, const RunStory& story, const record::Audit& audit,
                  const Provenance& provenance) {
  const record::RunHeader& run = selection.header();
  std::string html = html_heading(1, title_of(selection));
  html += html_paragraph(
      "Report of a measurement of stiffness and damping on " +
          (selection.has_rig() ? "the rig " + selection.rig().name : std::string("a rig whose file cannot be used")) +
          ".",
      "lead");
  if (selection.header().is_child())
    html +=
        html_paragraph("Child file of run " + run.parent_id + ", head " + run.parent_head +
                       ": its stream was computed again with the rig file below. Readings, losses and faults stand in "
                       "the file of that run.");
  html += html_paragraph("File as found when this report was made: " + audit_line(audit),
                         std::string("state ") + state_class(audit));
  if (!story.unreadable.empty()) {
    html += html_paragraph(
        "Parts of the file cannot be read. Readings, dwells, events or signatures below may be incomplete:");
    html += html_list(story.unreadable, "alarm");
    if (story.unreadable_left_out > 0)
      html += html_paragraph("and " + std::to_string(story.unreadable_left_out) + " more");
  }
  if (audit.state != record::AuditState::tampered && !audit.trusted)
    html += html_paragraph(
        std::string("No key was given to trust: compare the fingerprint with the one that the rig's service "
                    "shows.") +
        (audit.of_ledger ? " That the ledger knows the key proves nothing: who forges a run can forge its ledger."
                         : ""));
  html +=
      html_facts({{"begun", run.start_utc},
                  {"ended", ended_text(selection)},
                  {selection.header().is_child() ? "covers" : "duration", seconds_text(story.span_s, 1)},
                  {"samples", selection.header().is_child() ? std::string()
                                                            : std::to_string(story.samples) + " of " +
                                                                  std::to_string(story.traces.size()) + " channels"},
                  {"dwells", std::to_string(story.dwells.size() + story.dwells_left_out)},
                  {"file", selection.path()},
                  {"report made", provenance.made_utc + " by " + provenance.program}});
  return html;
}

std::string traces(const Selection& selection, const RunStory& story) {
  std::vector<Shaded> shaded;
  for (const DwellView& view : story.dwells)
    if (std::isfinite(view.dwell.settled_s))
      shaded.push_back({view.dwell.settled_s, view.dwell.end_s, std::to_string(view.dwell.index.value_or(0))});
  std::string html = html_heading(2, "Readings over time");
  html += html_paragraph("Smallest and largest reading in each of " + std::to_string(Trace::kBins) +
                             " parts of the run. Shaded: the data that count, with the number of their dwell." +
                             (selection.has_rig() ? "" : " Without a usable rig file: the devices' own numbers."),
                         "lead");
  const std::vector<Channel>& channels = selection.rig().channels;
  for (std::size_t i = 0; i < channels.size() && i < kTraces; ++i)
    html += trace_picture(story.traces[i], channels[i].name, channels[i].unit, story.begin_s, story.end_s, shaded);
  if (channels.size() > kTraces)
    html += html_paragraph("and " + std::to_string(channels.size() - kTraces) + " channels more, not drawn");
  return html;
}

std::string dwells(const RunStory& story) {
  std::string html = html_heading(2, "Dwells");
  if (story.dwells.empty()) html += html_paragraph("None: no drive was seen in this run.");
  for (const DwellView& view : story.dwells) html += report_dwell(view);
  if (story.dwells_left_out > 0)
    html += html_paragraph("and " + std::to_string(story.dwells_left_out) + " more, which are in the run file");
  return html;
}

}  // namespace

std::string report_page(const Selection& selection, const RunStory& story, const record::Audit& audit,
                        const Provenance& provenance) {
  std::string html = "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n";
  // No script, nothing from elsewhere: the browser refuses whatever a label might smuggle in.
  html += "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'\">\n";
  html += "<meta name=\"viewport\" content=\"width=device-width\">\n<title>" + escaped(title_of(selection)) +
          "</title>\n<style>" + kStyle + page_foot(selection, audit) + "</style></head>\n<body><main>\n";
  html += front(selection, story, audit, provenance);
  html += dwells(story);
  html += report_conditions(selection);
  html += report_channels(selection, story);
  if (!selection.header().is_child()) html += traces(selection, story);
  html += report_models(story);
  if (!selection.header().is_child()) html += report_losses(selection, story);
  html += report_events(story);
  html += report_audit(selection, story, audit);
  html += "<div class=\"sign\"><div>name</div><div>date</div><div>signature</div></div>\n";
  html += html_heading(2, "Rig file") + "<pre>" + escaped(selection.header().rig.text) + "</pre>\n";
  return html + "</main></body></html>\n";
}

Result<std::vector<std::string>> export_report(Selection& selection, const record::Audit& audit,
                                               const Provenance& provenance, const Target& target,
                                               const Progress& progress) {
  RunStory story = tell_run(selection, progress);
  auto file = OutputFile::create(target);
  if (!file) return tl::make_unexpected(file.error());
  file->write(report_page(selection, story, audit, provenance));
  if (auto done = file->keep(); !done) return tl::make_unexpected(done.error());
  return std::move(story.unreadable);
}

}  // namespace dwell::handon
