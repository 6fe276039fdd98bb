// The page of `dwellctl show`: what matters most first.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "daemon/ctl/run_summary.hpp"
#include "daemon/handon/selection.hpp"
#include "daemon/record/folded_events.hpp"
#include "daemon/report/dwell_text.hpp"
#include "daemon/report/line.hpp"
#include "daemon/report/number_text.hpp"
#include "daemon/report/stored_model_text.hpp"
#include "daemon/report/table.hpp"

namespace dwell::ctl {
namespace {

constexpr std::size_t kLabel = 11;       // columns of the words on the left
constexpr std::size_t kMostEvents = 60;  // on a page for people

void append(Section& to, const std::string& label, const std::string& text, std::size_t columns) {
  if (text.empty()) return;
  // The text alone: a long word, such as a path, would leave its label alone on a line.
  std::string front = pad_right(label, kLabel);
  for (const std::string& line : wrapped(printable(text), columns - kLabel, 0)) {
    to.body.push_back({front + line, Style::plain});
    front = std::string(kLabel, ' ');
  }
}

std::string list_of(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

std::string title_of(const RunSummary& run) {
  std::string text = run.header.is_child() ? "child file of run " + run.header.parent_id.substr(0, 8)
                                           : "run " + std::to_string(run.header.run);
  if (!run.header.label.empty()) text += " · " + run.header.label;
  return text + (run.end ? " · closed" : " · open: being recorded, or cut off");
}

std::string begun_text(const record::RunHeader& header) {
  std::string text = header.start_utc + " by the " + header.begun_by;
  if (header.begun_by == "replay") text = header.start_utc + ", computed by replay";
  if (header.person) text += ", " + record::who(*header.person);
  return text;
}

std::string origin_text(const record::Origin& origin) {
  std::string text = "on " + origin.host;
  if (!origin.time_zone.empty()) text += " (" + origin.time_zone + ")";
  return text + ", clock " + handon::clock_text(origin);
}

std::string stream_text(const RunSummary& run) {
  // The numbers of records and samples are those of the parent's stream.
  if (run.header.is_child()) return {};
  std::string text = run.span_s ? duration_text(*run.span_s) : std::string("nothing");
  if (run.end)
    text += ", " + std::to_string(run.end->records) + " records, " + std::to_string(run.end->samples) + " samples";
  return with_singular(std::move(text));
}

Section facts(const RunSummary& run, std::size_t columns) {
  const record::RunHeader& header = run.header;
  Section section;
  section.body.push_back({printable(clipped(title_of(run), columns)), Style::plain});
  const auto add = [&](const char* label, const std::string& text) { append(section, label, text, columns); };
  // A path has no blank to break at: a long one keeps a line of its own, and the size follows in the next.
  const std::string size = bytes_text(static_cast<double>(run.bytes));
  const bool fits = kLabel + width(run.file) + 2 + width(size) <= columns;
  add("file", run.file + (fits ? ", " + size : ""));
  if (!fits) add("size", size);
  add("rig", (run.rig.empty() ? "" : run.rig + ", ") + header.rig.path);
  add("SHA-256", header.rig.sha256);
  for (const record::KeptFile& file : header.files) {
    add("with", file.path + (file.holds_text() ? "" : "; its text is not in the run file"));
    add("SHA-256", file.sha256);
  }
  add("begun", begun_text(header));
  add("comment", header.comment);
  if (run.end && header.is_child()) add("computed", run.end->utc);
  if (run.end && !header.is_child())
    add("ended", (run.ended_utc.empty() ? kNoNumber : run.ended_utc) + ": " + run.end->why);
  add("stream", stream_text(run));
  if (header.is_child() && run.span_s) add("covers", duration_text(*run.span_s) + " of the parent's stream");
  add("channels", list_of(header.channels));
  add("recorded", origin_text(header.origin));
  add("program", "dwelld " + header.origin.version + ", " + header.origin.build);
  add("processor", header.origin.cpu);
  std::vector<std::string> plugins;
  for (const record::Plugin& plugin : header.plugins) plugins.push_back(plugin.driver + " " + plugin.version);
  add("drivers", list_of(plugins));
  add("parent", header.is_child() ? "run " + header.parent_id + ", head " + header.parent_head : "");
  add("key", run.key);
  return section;
}

std::vector<std::string> cells(const Dwell& dwell, Coefficient ElementEstimate::*which, const char* unit) {
  std::vector<NumberText> numbers;
  for (const ElementEstimate& e : dwell.elements)
    numbers.push_back(e.identifiable ? number_text((e.*which).value, (e.*which).U95, unit)
                                     : NumberText{kNoNumber, "", ""});
  std::vector<std::string> texts = join_aligned(numbers);
  for (std::size_t i = 0; i < texts.size(); ++i)
    if (dwell.elements[i].identifiable) texts[i] += marks(dwell, dwell.elements[i], dwell.elements[i].*which);
  return texts;
}

void append_wrapped(Section& to, const std::string& text, std::size_t columns) {
  if (text.empty()) return;
  for (std::string& line : wrapped(printable(text), columns, 2)) to.body.push_back({std::move(line), Style::plain});
}

Section dwell_section(const DwellView& view, std::size_t columns) {
  const Dwell& dwell = view.dwell;
  Section section;
  append_wrapped(section,
                 headline(view) + (dwell.state == State::complete ? "" : "; it went on when the record stopped"),
                 columns);
  if (dwell.elements.empty() && dwell.state == State::complete)
    append_wrapped(
        section,
        "no coefficients: " + (dwell.settling_reason.empty() ? "the dwell did not settle" : dwell.settling_reason),
        columns);
  for (const Doubt& doubt : dwell.doubts) append_wrapped(section, doubt_text(doubt), columns);
  if (std::isfinite(dwell.frequency_hz.value))
    append(section, "frequency", join(number_text(dwell.frequency_hz.value, kNormal95 * dwell.frequency_hz.u, "Hz")),
           columns);
  Table table;
  std::vector<std::string> numbers;
  for (const ElementEstimate& e : dwell.elements) numbers.push_back(std::to_string(e.k));
  table.add("element", numbers, Align::right);
  table.add("stiffness", cells(dwell, &ElementEstimate::stiffness, stiffness_unit(view.motion)));
  table.add("damping", cells(dwell, &ElementEstimate::damping, damping_unit(view.motion)));
  for (Section& part : table.sections(columns))
    for (std::vector<TextLine>* lines : {&part.head, &part.body})
      section.body.insert(section.body.end(), lines->begin(), lines->end());
  for (const ElementEstimate& e : dwell.elements)
    if (!e.identifiable)
      append_wrapped(section, "element " + std::to_string(e.k) + " is not identifiable: " + e.reason, columns);
  return section;
}

// An instant to the millisecond, without its date if that is the run's.
std::string instant(const std::string& utc, const record::RunHeader& header) {
  constexpr std::size_t kDate = 11;          // "2026-07-01T"
  constexpr std::size_t kMilliseconds = 23;  // of "2026-07-01T10:12:03.123456Z"
  const bool same = utc.size() > kDate && utc.compare(0, kDate, header.start_utc, 0, kDate) == 0;
  const std::string text = utc.size() > kMilliseconds ? utc.substr(0, kMilliseconds) : utc;
  return same ? text.substr(kDate) : text;
}

std::string event_text(const record::FoldedEvent& folded, const record::RunHeader& header) {
  const record::StoredEvent& event = folded.event;
  std::string text = with_singular(event.text);
  if (folded.entries > 1) text += ", up to " + instant(folded.last_utc, header);
  const std::string who = event.person ? record::who(*event.person) : "";
  if (text.find(who) == std::string::npos) text += ", by " + who;
  if (event.before != event.after) text += ": " + event.before + " → " + event.after;
  return event.comment.empty() ? text : text + ": " + event.comment;
}

// Of entries that the summary does not keep; empty: it keeps all.
std::string left_out_text(std::uint64_t count, const char* what) {
  if (count == 0) return {};
  return "and " + std::to_string(count) + " more " + what + ", left out here and with --json: show keeps " +
         bytes_text(static_cast<double>(RunSummary::kListBytes)) + " of them";
}

Section event_section(const RunSummary& run, bool losses, std::size_t columns) {
  std::size_t when = 0;
  std::size_t what = 0;
  std::size_t left_out = 0;
  const std::vector<record::FoldedEvent> all = record::folded(run.events);
  std::vector<const record::FoldedEvent*> shown;
  for (const record::FoldedEvent& one : all) {
    const record::StoredEvent& event = one.event;
    if ((event.what == "loss") != losses) continue;
    if (shown.size() == kMostEvents) {
      ++left_out;
      continue;
    }
    shown.push_back(&one);
    when = std::max(when, width(printable(instant(event.utc, run.header))));
    what = std::max(what, width(printable(event.what)));
  }
  Section section;
  if (shown.empty() && (losses || run.left_out.events == 0)) return section;
  section.head.push_back({losses ? "losses" : "events", Style::title});
  for (const record::FoldedEvent* one : shown) {
    std::string line = "  " + pad_right(printable(instant(one->event.utc, run.header)), when) + "  ";
    if (!losses) line += pad_right(printable(one->event.what), what) + "  ";
    const std::size_t indent = width(line);
    for (std::string& part : wrapped(line + printable(event_text(*one, run.header)), columns, indent))
      section.body.push_back({std::move(part), Style::plain});
  }
  if (left_out > 0)
    section.body.push_back({"  and " + std::to_string(left_out) + " more, which --json shows", Style::plain});
  // Events that are left out may be losses too. They stand once, behind the last list.
  if (!losses && run.left_out.events > 0)
    append_wrapped(section, "  " + left_out_text(run.left_out.events, "events and losses"), columns);
  return section;
}

bool is_verification(const record::StoredModel& model) { return model.kind == "verification"; }

Section model_section(const RunSummary& run, std::size_t columns) {
  Section section;
  if (run.models.empty() && run.left_out.models == 0) return section;
  section.head.push_back({"estimates and verifications", Style::title});
  const std::size_t left_out = run.models.size() - std::min(run.models.size(), kMostEvents);
  if (left_out > 0)
    section.body.push_back({"  the last " + std::to_string(kMostEvents) + " of " + std::to_string(run.models.size()) +
                                "; --json shows them",
                            Style::plain});
  for (std::size_t i = left_out; i < run.models.size(); ++i) {
    const record::StoredModel& model = run.models[i];
    const std::string line = "  " + printable(instant(model.utc, run.header)) + "  " + pad_right(model.kind, 12) + "  ";
    for (std::string& part :
         wrapped(line + printable(stored_model_text(model.kind, model.from, model.result)), columns, width(line)))
      section.body.push_back({std::move(part), Style::plain});
  }
  if (std::any_of(run.models.begin(), run.models.end(), is_verification))
    append_wrapped(section, "  " + std::string(kMeaningOfEn), columns);
  if (run.left_out.models > 0)
    append_wrapped(section, "  " + left_out_text(run.left_out.models, "estimates and verifications"), columns);
  return section;
}

Section signature_section(const RunSummary& run, std::size_t columns) {
  Section section;
  if (run.signatures.empty()) return section;
  section.head.push_back({"signatures", Style::title});
  for (const record::PersonalSignature& signature : run.signatures)
    for (std::string& line : wrapped("  " + printable(signature_text(signature)), columns, 4))
      section.body.push_back({std::move(line), Style::plain});
  return section;
}

Section unreadable_section(const RunSummary& run, std::size_t columns) {
  Section section;
  if (run.unreadable.empty()) return section;
  section.head.push_back({"cannot be read; the rest stands below", Style::title});
  for (const std::string& why : run.unreadable) append_wrapped(section, "  " + why, columns);
  if (run.left_out.unreadable > 0)
    append_wrapped(section, "  and " + std::to_string(run.left_out.unreadable) + " more", columns);
  return section;
}

}  // namespace

std::string signature_text(const record::PersonalSignature& signature) {
  std::string text = signature.name + ": " + signature.meaning;
  if (!signature.reason.empty()) text += " (" + signature.reason + ")";
  text += ", " + signature.utc;
  if (signature.person) return "countersigned by the service for " + record::who(*signature.person) + ": " + text;
  const auto key = record::PublicKey::parse(signature.vkey);
  return "with the key " + (key ? key->name() + " " + key->fingerprint() : "that is not readable") + ": " + text;
}

std::string summary_page(const RunSummary& run, std::size_t columns) {
  std::vector<Section> sections{facts(run, columns), unreadable_section(run, columns)};
  std::vector<const Dwell*> dwells;
  for (const DwellView& view : run.dwells) {
    sections.push_back(dwell_section(view, columns));
    dwells.push_back(&view.dwell);
  }
  Section notes;
  append_wrapped(notes, left_out_text(run.left_out.dwells, "dwells"), columns);
  if (run.dwells.empty() && run.left_out.dwells == 0)
    notes.body.push_back({run.unreadable.empty() ? "no dwell in this run" : "no dwell that can be read", Style::plain});
  for (const std::string& text : legend_of(dwells)) append_wrapped(notes, text, columns);
  sections.push_back(std::move(notes));
  sections.push_back(model_section(run, columns));
  for (const bool losses : {true, false}) sections.push_back(event_section(run, losses, columns));
  sections.push_back(signature_section(run, columns));
  Section last;
  append_wrapped(last, "Whether anything was altered: dwellctl audit " + run.file, columns);
  sections.push_back(std::move(last));
  sections.erase(std::remove_if(sections.begin(), sections.end(), [](const Section& s) { return s.body.empty(); }),
                 sections.end());
  return plain_text(sections);
}

}  // namespace dwell::ctl
