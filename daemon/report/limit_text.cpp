#include "daemon/report/limit_text.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <utility>
#include <vector>

#include "daemon/report/number_text.hpp"

namespace dwell {
namespace {

constexpr int kLeastDigits = 4;      // of a bound, significant: "7.500 to 8.500 kN/m" lines up
constexpr std::size_t kIndent = 11;  // as the lines on settling

void add(Section& section, const std::string& text, const TextOptions& options, Style style) {
  for (std::string& line : wrapped(printable("limits     " + text), options.columns, kIndent))
    section.body.push_back({std::move(line), options.age.empty() || options.result ? style : Style::old});
}

// With as many digits as it takes for the text to be the bound, and no more than kMaxDigits: a rounded bound would look
// kept, or violated, where it is not.
NumberText bound_text(double bound, std::string_view unit) {
  int digits = kLeastDigits;
  std::array<char, 32> text{};
  for (; digits < kMaxDigits; ++digits) {
    std::snprintf(text.data(), text.size(), "%.*e", digits - 1, bound);
    if (std::strtod(text.data(), nullptr) == bound) break;
  }
  return number_text(bound, unit, digits);
}

const char* unit_of(const JudgedLimit& limit, Motion motion) {
  return limit.kind == CoefficientKind::stiffness ? stiffness_unit(motion) : damping_unit(motion);
}

bool one_sided(const Bounds& bounds) { return !std::isfinite(bounds.low) || !std::isfinite(bounds.high); }

// The only bound of a one-sided limit.
std::string end_text(const JudgedLimit& limit, const char* unit) {
  return join(bound_text(std::isfinite(limit.bounds.low) ? limit.bounds.low : limit.bounds.high, unit));
}

}  // namespace

std::string limited_text(const JudgedLimit& limit) {
  return std::string(to_string(limit.kind)) + " of element " + std::to_string(limit.element);
}

std::string bounds_text(const JudgedLimit& limit, Motion motion) {
  const char* const unit = unit_of(limit, motion);
  if (one_sided(limit.bounds))
    return (std::isfinite(limit.bounds.low) ? "at least " : "at most ") + end_text(limit, unit);
  const NumberText low = bound_text(limit.bounds.low, unit);
  const NumberText high = bound_text(limit.bounds.high, unit);
  return (low.unit == high.unit ? low.value : join(low)) + " to " + join(high);
}

std::string violation_text(const JudgedLimit& limit, const Dwell& dwell, Motion motion) {
  std::string text = limited_text(limit);
  for (const ElementEstimate& e : dwell.elements) {
    if (e.k != limit.element) continue;
    const Coefficient& c = limit.kind == CoefficientKind::stiffness ? e.stiffness : e.damping;
    text += " is " + join(number_text(c.value, c.U95, unit_of(limit, motion)));
  }
  return text + (one_sided(limit.bounds) ? ", not " : ", outside ") + bounds_text(limit, motion);
}

Section limit_section(const DwellView& view, const TextOptions& options) {
  Section section;
  section.name = kLimits;
  if (view.dwell.elements.empty()) return section;
  std::string kept;
  std::vector<std::pair<std::string, std::string>> none;  // by reason: of which
  for (const JudgedLimit& limit : view.limits)
    if (limit.verdict == LimitVerdict::violated)
      add(section, "violated: " + violation_text(limit, view.dwell, view.motion), options, Style::alarm);
  for (const JudgedLimit& limit : view.limits) {
    const std::string what = limited_text(limit);
    if (limit.verdict == LimitVerdict::undecided)
      add(section,
          "undecided: ± of the " + what + " reaches over " +
              (one_sided(limit.bounds) ? end_text(limit, unit_of(limit, view.motion))
                                       : "an end of " + bounds_text(limit, view.motion)),
          options, Style::plain);
    if (limit.verdict == LimitVerdict::kept)
      kept += (kept.empty() ? "" : "; ") + what + ", " + bounds_text(limit, view.motion);
    if (limit.verdict != LimitVerdict::none) continue;
    // The doubt itself stands above the numbers.
    const std::string reason = limit.doubted ? kDoubtedNumber : limit.reason;
    const auto same = std::find_if(none.begin(), none.end(), [&](const auto& n) { return n.first == reason; });
    if (same == none.end())
      none.emplace_back(reason, what);
    else
      same->second += ", " + what;
  }
  if (!kept.empty()) add(section, "kept: " + kept, options, Style::plain);
  for (const auto& [reason, which] : none)
    add(section, "no verdict on " + which + ": " + reason, options, Style::plain);
  return section;
}

}  // namespace dwell
