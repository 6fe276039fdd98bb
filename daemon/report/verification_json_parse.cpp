#include <utility>

#include "daemon/report/json_reader.hpp"
#include "daemon/report/missing_report.hpp"
#include "daemon/report/verification_json.hpp"

namespace dwell {
namespace {

using namespace json_reader;

ChannelComparison comparison(const Json& value, int channel) {
  ChannelComparison c;
  c.channel = channel;
  c.verdict = named(string_of(value, "verdict"), "verdict", Verdict::not_verified);
  c.samples = static_cast<std::size_t>(integer(member(value, "samples"), "samples"));
  c.rms = real_of(value, "rms");
  c.error = real_of(value, "error");
  c.U = real_of(value, "U");
  c.U_as_is = real_of(value, "U_as_is");
  c.noise = real_of(value, "noise");
  c.beyond_steady = real_of(value, "beyond_steady");
  c.e_n = real_of(value, "e_n");
  c.fit_percent = real_of(value, "fit_percent");
  c.frac = real_of(value, "frac");
  const Json& figures = member(value, "sprague_geers");
  c.sprague_geers = {real_of(figures, "magnitude"), real_of(figures, "phase"), real_of(figures, "combined")};
  return c;
}

VerificationView verification_view(const Json& value) {
  VerificationView view;
  Verification& v = view.verification;
  if (const Json& index = member(value, "dwell"); !index.is_null()) view.dwell = integer(index, "dwell");
  v.verdict = named(string_of(value, "verdict"), "verdict", Verdict::not_verified);
  if (!member(value, "consistent").is_null()) v.consistent = boolean_of(value, "consistent");
  v.reasons = strings_of(value, "reasons");
  v.e_n = real_of(value, "e_n");
  v.chi2 = real_of(value, "chi2");
  v.p = real_of(value, "p");
  const Json& accuracy = member(value, "accuracy");
  v.accuracy = real_of(accuracy, "asked");
  v.seen = real_of(accuracy, "seen");
  v.U = real_of(accuracy, "U");
  for (const Json& channel : array_of(value, "channels")) {
    v.channels.push_back(comparison(channel, static_cast<int>(view.channels.size())));
    view.channels.push_back({string_of(channel, "channel"), string_of(channel, "unit")});
  }
  v.missing = missing_from(array_of(value, "missing"));
  v.evidence = strings_of(value, "evidence");
  v.cannot_be_checked = strings_of(value, "cannot_be_checked");
  return view;
}

}  // namespace

tl::expected<VerificationView, std::string> verification_from_json(const Json& value) {
  try {
    return verification_view(value);
  } catch (const Mistake& mistake) {
    return tl::unexpected("verification: " + std::string(mistake.what()));
  }
}

}  // namespace dwell
