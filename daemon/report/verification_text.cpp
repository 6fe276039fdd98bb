#include "daemon/report/verification_text.hpp"

#include <cmath>
#include <cstdio>

#include "core/base/wording.hpp"
#include "daemon/report/missing_report.hpp"
#include "daemon/report/number_text.hpp"
#include "daemon/report/table.hpp"

namespace dwell {
namespace {

std::string part(double value) { return std::isfinite(value) ? brief(100 * value, 2) + " %" : kNoNumber; }
std::string figure(double value, int digits) { return std::isfinite(value) ? brief(value, digits) : kNoNumber; }

std::string paragraph(const std::string& head, const std::string& text) {
  return pad_right(head, 12) + printable(text) + "\n";
}

// The transient is that of the dwell itself; other dwells are named already.
std::string of_dwell(const VerificationView& view, const std::string& evidence) {
  const bool own = evidence.rfind("transient", 0) == 0;
  return (own && view.dwell ? "dwell " + std::to_string(*view.dwell) + ", " : "") + evidence;
}

Table channel_table(const VerificationView& view) {
  const Verification& v = view.verification;
  std::vector<std::string> names, verdicts, rms, errors, U, as_is, noise, beyond, e_n, fit, magnitude, phase, frac;
  bool several = false;  // frequencies
  for (const ChannelComparison& c : v.channels) {
    const ChannelLabel& label = view.channels[static_cast<std::size_t>(c.channel)];
    names.push_back(label.name);
    verdicts.emplace_back(to_string(c.verdict));
    rms.push_back(join(number_text(c.rms, label.unit, 3)));
    errors.push_back(part(c.error));
    U.push_back("± " + part(c.U));
    as_is.push_back("± " + part(c.U_as_is));
    noise.push_back(part(c.noise));
    beyond.push_back(part(c.beyond_steady));
    e_n.push_back(figure(c.e_n, 2));
    fit.push_back(std::isfinite(c.fit_percent) ? brief(c.fit_percent, 4) + " %" : kNoNumber);
    magnitude.push_back(part(c.sprague_geers.magnitude));
    phase.push_back(part(c.sprague_geers.phase));
    frac.push_back(figure(c.frac, 4));
    several = several || std::isfinite(c.frac);
  }
  Table table;
  table.add("channel", std::move(names));
  table.add("verdict", std::move(verdicts));
  table.add("rms", std::move(rms), Align::right);
  table.add("error", std::move(errors), Align::right);
  table.add("U", std::move(U), Align::left, true);
  table.add("as is", std::move(as_is), Align::left);
  table.add("noise", std::move(noise), Align::right);
  table.add("unsteady", std::move(beyond), Align::right);
  table.add("E_n", std::move(e_n), Align::right);
  table.add("fit", std::move(fit), Align::right);
  table.add("magnitude", std::move(magnitude), Align::right);
  table.add("phase", std::move(phase), Align::right);
  if (several) table.add("FRAC", std::move(frac), Align::right);
  return table;
}

}  // namespace

VerificationView make_view(const Verification& verification, const Rig& rig, const Dwell& dwell) {
  return {rig.name, channel_labels(rig), dwell.index, verification};
}

std::string verification_text(const VerificationView& view) {
  const Verification& v = view.verification;
  std::string text = view.rig.empty() ? "" : "rig " + printable(view.rig) + "\n\n";
  text += paragraph("verdict", std::string(to_string(v.verdict)) + " for predictions within " + percent(v.accuracy) +
                                   " of each channel's rms" +
                                   (std::isfinite(v.seen) ? "; seen " + part(v.seen) + " ± " + part(v.U) : ""));
  if (v.consistent)
    text += paragraph("consistent", *v.consistent ? "yes: noise and stated uncertainties explain what is left"
                                                  : "no: something is left that they do not explain");
  if (std::isfinite(v.chi2))
    text += paragraph("statistics", "squares left over those of noise and stated uncertainties: " + brief(v.chi2, 3) +
                                        "; as much by chance: p = " + brief(v.p, 2));
  for (const std::string& evidence : v.evidence) text += paragraph("evidence", of_dwell(view, evidence));
  for (const std::string& reason : v.reasons) text += paragraph("reason", reason);
  for (const MissingTerm& term : v.missing) text += paragraph("missing", missing_text(term));
  for (const std::string& what : v.cannot_be_checked) text += paragraph("unchecked", what + ": cannot be checked here");
  if (v.channels.empty()) return text;
  text += "\n" + channel_table(view).text();
  text +=
      "error: rms of predicted minus measured. unsteady: rms of what the steady phasors do not predict. error, U,\n"
      "noise and unsteady are parts of the channel's rms. U: expanded uncertainty (k = 2). as is: U of the error\n"
      "without noise, for the coefficients as they are. magnitude, phase: Sprague and Geers.\n";
  return text;
}

}  // namespace dwell
