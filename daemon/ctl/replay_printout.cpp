#include "daemon/ctl/replay_printout.hpp"

#include <cstdio>
#include <utility>

#include "daemon/report/json_parts.hpp"
#include "daemon/report/number_text.hpp"

namespace dwell::ctl {
namespace {

constexpr std::size_t kShown = 50;  // differences shown as text; JSON holds all that were kept

std::string two_digits(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g", value);
  return text;
}

std::string count(std::uint64_t n, const char* one, const char* many) {
  return std::to_string(n) + " " + (n == 1 ? one : many);
}

std::string also(std::uint64_t n, const char* one, const char* many) { return n > 0 ? ", " + count(n, one, many) : ""; }

// Cuts long values, for instance a reason in words.
std::string shown(const std::string& value) {
  constexpr std::size_t most = 120;
  if (value.empty()) return "nothing";
  return printable(value.size() > most ? value.substr(0, most) + "…" : value);
}

std::string place(const Finding& finding) {
  if (finding.dwell.empty())
    return "record " + std::to_string(finding.position) + ": " + printable(finding.difference.what);
  return "dwell " + finding.dwell + (finding.final ? " at its end" : "") + ", record " +
         std::to_string(finding.position) + ": " + printable(finding.difference.what);
}

std::string line(const Finding& finding) {
  const Difference& d = finding.difference;
  std::string text = place(finding) + ": stored " + shown(d.stored) + ", replayed " + shown(d.replayed);
  if (d.in_u >= 0.0) text += ", " + two_digits(d.in_u) + " u";
  return text;
}

Json value_of(const std::string& text) {
  Json value = Json::parse(text, nullptr, false);
  if (value.is_discarded()) return text.empty() ? Json(nullptr) : Json(text);
  return value;
}

Json json(const Finding& finding) {
  const Difference& d = finding.difference;
  return {{"dwell", finding.dwell.empty() || finding.dwell == "none" ? Json(nullptr) : value_of(finding.dwell)},
          {"position", finding.position},
          {"final", finding.final},
          {"what", d.what},
          {"stored", value_of(d.stored)},
          {"replayed", value_of(d.replayed)},
          {"difference_u", json_number(d.in_u)},
          {"tolerable", d.tolerable}};
}

std::string words(const record::Origin& origin) {
  return printable(origin.version + "; " + origin.build + "; " + origin.cpu);
}

std::string headline(const ReplayVerdict& verdict, const ReplayFindings& findings) {
  const std::string seen = count(findings.results + findings.finals, "result", "results") + ", " +
                           std::to_string(findings.finals) + " of dwells that ended, " +
                           count(findings.numbers, "number", "numbers") + also(findings.events, "event", "events") +
                           also(findings.estimates, "estimate", "estimates") +
                           also(findings.verifications, "verification", "verifications");
  if (findings.identical()) return "identical: " + seen + ", bit for bit";
  const std::string different = count(findings.different, "difference", "differences") + " in " + seen;
  if (verdict.same)
    return "the same within " + two_digits(kReplayTolerance) + " u, on another build or processor: " + different;
  if (verdict.same_origin) return "not identical: " + different;
  return "not the same: " + different + ", " + std::to_string(findings.intolerable) + " beyond " +
         two_digits(kReplayTolerance) + " u";
}

}  // namespace

ReplayVerdict judge(const ReplayFindings& findings, const record::Origin& recorded, record::Origin here) {
  ReplayVerdict verdict;
  verdict.same_origin = recorded.version == here.version && recorded.build == here.build && recorded.cpu == here.cpu;
  verdict.same = verdict.same_origin ? findings.identical() : findings.intolerable == 0;
  verdict.here = std::move(here);
  return verdict;
}

void add(const ReplayVerdict& verdict, const ReplayFindings& findings, const record::RunHeader& run, Printout& to) {
  Json& document = to.document;
  document["run"] = {{"id", run.id}, {"number", run.run}, {"label", run.label}};
  document["identical"] = findings.identical();
  document["same_origin"] = verdict.same_origin;
  document["within_tolerance"] = findings.intolerable == 0;
  document["tolerance_u"] = kReplayTolerance;
  document["compared"] = {{"results", findings.results + findings.finals},
                          {"finals", findings.finals},
                          {"numbers", findings.numbers},
                          {"events", findings.events},
                          {"estimates", findings.estimates},
                          {"verifications", findings.verifications}};
  document["different"] = findings.different;
  document["differences"] = Json::array();
  for (const Finding& finding : findings.listed()) document["differences"].push_back(json(finding));
  document["notes"] = findings.notes;

  std::string& text = to.text;
  text += "\nreplay  " + headline(verdict, findings) + "\n";
  const std::string margin = "        ";
  if (findings.largest.position > 0)
    text += margin + "the largest of those within the tolerance: " + line(findings.largest) + "\n";
  std::size_t lines = 0;
  for (const Finding& finding : findings.listed()) {
    if (finding.difference.tolerable && !verdict.same_origin) continue;
    if (++lines > kShown) break;
    text += margin + line(finding) + "\n";
  }
  const std::uint64_t counted = verdict.same_origin ? findings.different : findings.intolerable;
  if (counted > lines || lines > kShown)
    text += margin + "… " + count(counted, "difference", "differences") + " in all\n";
  for (const std::string& note : findings.notes) text += margin + printable(note) + "\n";
  if (verdict.same_origin) return;
  text += margin + "recorded by  " + words(run.origin) + "\n" + margin + "replayed by  " + words(verdict.here) + "\n";
}

void add_parent(const record::RunHeader& parent, const std::string& child, Printout& to) {
  to.document["parent"] = parent.id;
  to.document["child"] = child.empty() ? Json(nullptr) : Json(child);
  to.text += "\nreplay  of run " + printable(parent.id) + " with another rig file" +
             (child.empty() ? "" : "; written to " + printable(child)) + "\n";
}

}  // namespace dwell::ctl
