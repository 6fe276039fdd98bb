// The report on the run as a whole: conditions, channels, losses, events, audit.
#include <algorithm>
#include <cmath>

#include "config/units.hpp"
#include "daemon/handon/csv.hpp"
#include "daemon/handon/html.hpp"
#include "daemon/handon/picture.hpp"
#include "daemon/handon/report.hpp"
#include "daemon/record/folded_events.hpp"
#include "daemon/record/stream_events.hpp"
#include "daemon/report/number_text.hpp"
#include "daemon/report/stored_model_text.hpp"

namespace dwell::handon {
namespace {

Markup hash(const std::string& text) { return Markup::made(text.empty() ? "" : "<code>" + escaped(text) + "</code>"); }

std::string frequency_text(const Excitation& e) {
  std::string text = axis_number(e.frequency_hz) + " Hz nominal, searched from " + axis_number(e.search_low_hz) +
                     " to " + axis_number(e.search_high_hz) + " Hz; reference ";
  switch (e.reference) {
    case Reference::fixed:
      return text + "fixed";
    case Reference::tracked:
      return text + "tracked";
    case Reference::sync:
      return text + "sync pulses";
  }
  return text;
}

std::string filter_text(const Filter& filter, const char* what) {
  if (filter.kind == FilterKind::none) return {};
  static constexpr const char* names[] = {"", "Butterworth", "Bessel", "RC"};
  return std::string(names[static_cast<std::size_t>(filter.kind)]) + " " + what + " of order " +
         std::to_string(filter.order) + " at " + axis_number(filter.hz) + " Hz";
}

// How a reading differs from the motion, beside scale and offset: delay and filters.
std::string response_text(const Rig& rig, const Channel& c) {
  const double delay_s = c.delay_s + (c.device >= 0 ? rig.devices[static_cast<std::size_t>(c.device)].delay_s : 0.0);
  std::string text = delay_s != 0.0 ? "delay " + join(number_text(delay_s, "s", 4)) : "";
  for (const std::string& part : {filter_text(c.lowpass, "low-pass"), filter_text(c.highpass, "high-pass")})
    if (!part.empty()) text += (text.empty() ? "" : "; ") + part;
  return text;
}

Markup calibration(const Channel& c, const std::string& start_utc) {
  if (c.calibration.id.empty()) return {"none stated"};
  std::string html = escaped(c.calibration.id);
  if (!c.calibration.due.empty()) {
    html += ", due " + escaped(c.calibration.due);
    // ISO dates sort as text.
    if (start_utc.size() >= 10 && c.calibration.due < start_utc.substr(0, 10))
      html += " <strong class=\"alarm\">overdue</strong>";
  }
  return Markup::made(html);
}

std::string number_or(double count) { return axis_number(count); }

}  // namespace

std::string report_conditions(const Selection& selection) {
  const record::RunHeader& run = selection.header();
  const record::Origin& origin = run.origin;
  const Rig& rig = selection.rig();
  std::string plugins;
  for (const record::Plugin& plugin : run.plugins)
    plugins += (plugins.empty() ? "" : ", ") + plugin.driver + " " + plugin.version;
  std::string html = html_heading(2, "Conditions");
  html += html_facts({{"begun by", run.begun_by + (run.person ? ": " + record::who(*run.person) : std::string())},
                      {"comment", run.comment},
                      {"host", origin.host + (origin.time_zone.empty() ? "" : ", time zone " + origin.time_zone)},
                      {"clock", clock_text(origin)},
                      {"program", "dwell " + origin.version + (plugins.empty() ? "" : "; drivers: " + plugins)},
                      {"build", origin.build},
                      {"processor", origin.cpu},
                      {"computed from", run.is_child() ? "run " + run.parent_id : std::string()}});
  if (!selection.has_rig()) return html;
  html += html_heading(2, Markup("Rig: " + rig.name));
  html += chain_picture(rig);
  html += html_facts({{"motion", std::string(config::to_string(rig.motion)) +
                                     (rig.boundary == Boundary::clamped ? "; the last element ends at the ground"
                                                                        : "; nothing beyond the last mass")},
                      {"drive", frequency_text(rig.excitation)},
                      {"harmonics fitted", std::to_string(rig.excitation.harmonics)},
                      {"transient allowed", axis_number(100.0 * rig.tolerance) + " % of each channel's amplitude"}});
  return html;
}

std::string report_channels(const Selection& selection, const RunStory& story) {
  const Rig& rig = selection.rig();
  const bool of_stream = !selection.header().is_child();  // else the samples stand in the parent's file
  std::vector<std::vector<Markup>> rows;
  for (std::size_t i = 0; i < rig.channels.size(); ++i) {
    const Channel& c = rig.channels[i];
    if (!selection.has_rig()) {
      rows.push_back({std::to_string(i + 1), c.name});
      if (of_stream) rows.back().push_back(std::to_string(story.traces[i].count()));
      continue;
    }
    const std::string device = c.device >= 0 ? rig.devices[static_cast<std::size_t>(c.device)].name : "";
    std::string scale =
        shortest(c.scale) +
        (c.offset != 0.0 ? (c.offset > 0.0 ? " · raw + " : " · raw − ") + shortest(std::fabs(c.offset)) : " · raw");
    if (c.stated.scale_u) scale += "; u " + axis_number(100.0 * c.scale_u) + " %";
    rows.push_back({std::to_string(i + 1), c.name, measurand_text(c), pretty_unit(c.unit), scale, response_text(rig, c),
                    calibration(c, selection.header().start_utc), device});
    if (of_stream) rows.back().push_back(std::to_string(story.traces[i].count()));
  }
  std::vector<Column> columns{{"no.", true}, {"channel"},  {"measures"},    {"unit"},
                              {"in unit"},   {"response"}, {"calibration"}, {"device", false, true}};
  if (!selection.has_rig()) columns.resize(2);
  if (of_stream) columns.push_back({"samples", true});
  return html_heading(2, "Channels") + html_table(columns, rows);
}

std::string report_losses(const Selection& selection, const RunStory& story) {
  const Rig& rig = selection.rig();
  std::vector<std::vector<Markup>> rows;
  for (const auto& [key, count] : story.lost) {
    const std::string channel = key.first < rig.channels.size() ? rig.channels[key.first].name : "?";
    rows.push_back({"channel " + channel, record::loss_text(key.second), number_or(count)});
  }
  for (const auto& [key, count] : story.faults) {
    const std::string device = key.first < rig.devices.size() ? rig.devices[key.first].name : "?";
    rows.push_back({"device " + device, to_string(key.second), number_or(count)});
  }
  std::string html = html_heading(2, "Losses and faults");
  if (rows.empty()) return html + html_paragraph("None: every sample that a driver handed in is in the record.");
  return html + html_table({{"where"}, {"what"}, {"how often", true}}, rows);
}

namespace {

// The coefficients of the newest estimate, below what stands against them; empty: it has none, as its line says. An
// older one's are not shown in their place: what refused them holds for those as well.
std::string last_coefficients(const std::vector<record::StoredModel>& models) {
  const auto newest = std::find_if(models.rbegin(), models.rend(),
                                   [](const record::StoredModel& model) { return model.kind == "estimate"; });
  if (newest == models.rend()) return {};
  std::vector<std::vector<Markup>> rows;
  for (const StoredElement& element : stored_elements(newest->result))
    rows.push_back({element.k, element.stiffness, element.damping});
  if (rows.empty()) return {};
  return html_heading(3, "Coefficients of the last estimate, " + newest->utc) +
         html_list(stored_cautions(newest->result), "warning") +
         html_table({{"element", true}, {"stiffness c", true}, {"damping r", true}}, rows) +
         html_list({"± is the half width of the 95 % interval, if the rig is as its file says"}, "notes");
}

}  // namespace

std::string report_models(const RunStory& story) {
  if (story.models.empty()) return {};
  const bool verified = std::any_of(story.models.begin(), story.models.end(),
                                    [](const record::StoredModel& model) { return model.kind == "verification"; });
  std::vector<std::vector<Markup>> rows;
  for (const record::StoredModel& model : story.models)
    rows.push_back({model.utc, model.kind, stored_model_text(model.kind, model.from, model.result)});
  return html_heading(2, "Estimates and verifications") +
         html_paragraph("Coefficients from transients, and verifications, as they were published during the run.") +
         html_table({{"when", false, true}, {"what", false, true}, {"text"}}, rows) +
         (verified ? html_list({std::string(kMeaningOfEn) + "."}, "notes") : std::string()) +
         (story.models_left_out == 0
              ? std::string()
              : html_paragraph("and " + std::to_string(story.models_left_out) + " more, which are in the run file")) +
         (story.models_left_out == 0 ? last_coefficients(story.models) : std::string());
}

std::string report_events(const RunStory& story) {
  std::string html = html_heading(2, "Events");
  std::vector<std::vector<Markup>> rows;
  for (const record::FoldedEvent& folded : record::folded(story.events)) {
    const record::StoredEvent& event = folded.event;
    std::string text = with_singular(event.text);
    const bool same_day = folded.last_utc.size() > 11 && event.utc.compare(0, 11, folded.last_utc, 0, 11) == 0;
    if (folded.entries > 1) text += ", up to " + (same_day ? folded.last_utc.substr(11) : folded.last_utc);
    if (!event.before.empty() || !event.after.empty()) text += "; before: " + event.before + ", after: " + event.after;
    if (!event.comment.empty()) text += "; comment: " + event.comment;
    rows.push_back({event.utc, event.what, text, event.person ? record::who(*event.person) : std::string()});
  }
  if (rows.empty()) return html + html_paragraph("None.");
  html += html_table({{"when", false, true}, {"what", false, true}, {"text"}, {"who"}}, rows);
  if (story.events_left_out > 0)
    html += html_paragraph("and " + std::to_string(story.events_left_out) + " more, which are in the run file");
  return html;
}

std::string report_audit(const Selection& selection, const RunStory& story, const record::Audit& audit) {
  const record::RunHeader& run = selection.header();
  std::string html = html_heading(2, "Audit");
  html += html_facts({{"state", audit_line(audit)},
                      {"valid up to", audit.until_utc},
                      {"head", hash(audit.head)},
                      {"signed by", hash(audit.key)},
                      {"key", hash(run.vkey)},
                      {"run", hash(run.id)},
                      {"head of the run before", hash(run.previous_head)},
                      {"computed from the head", hash(run.parent_head)},
                      {"rig file", Markup::made(escaped(run.rig.path) + " " + hash(run.rig.sha256).html())}});
  std::vector<std::vector<Markup>> files;
  for (const record::KeptFile& file : run.files)
    files.push_back({file.path, file.sha256.empty() ? Markup("not known") : hash(file.sha256),
                     file.holds_text() ? "in the run file" : "too large for the run file"});
  if (!files.empty()) html += html_table({{"file that the rig file names"}, {"SHA-256"}, {"text"}}, files);
  html += html_heading(3, "Signatures");
  std::vector<std::vector<Markup>> rows;
  for (const record::PersonalSignature& s : story.signatures)
    rows.push_back({s.name, s.meaning, s.reason, s.utc,
                    s.person ? "the service, for " + record::who(*s.person) : std::string("a key of their own"),
                    Markup::made("entry " + std::to_string(s.seq) + " " + hash(s.head.substr(0, 16)).html() + "…")});
  if (rows.empty()) {
    if (audit.signatures.empty()) html += html_paragraph("None in the file.");
  } else {
    html += html_table({{"name"}, {"meaning"}, {"reason"}, {"when"}, {"vouched for by"}, {"over"}}, rows);
  }
  std::vector<std::string> lines;
  for (const record::AuditedSignature& one : audit.signatures) lines.push_back(one.text);
  html += html_list(lines, "notes");
  return html;
}

}  // namespace dwell::handon
