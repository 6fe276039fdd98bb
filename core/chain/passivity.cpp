#include "core/chain/passivity.hpp"

#include <algorithm>
#include <string>

#include "core/base/wording.hpp"

namespace dwell {
namespace {

bool negative(const Coefficient& coefficient) { return coefficient.value < -coefficient.U95; }
// Below by 3.9 standard uncertainties: a coefficient of zero comes out so once in 20 000 times.
bool beyond_chance(const Coefficient& coefficient) { return coefficient.value < -2 * coefficient.U95; }

std::string first_of(std::vector<std::string> names, const char* what) {
  if (names.size() > kNamedAtMost) {
    const std::string more = std::to_string(names.size() - kNamedAtMost) + " more " + what;
    names.resize(kNamedAtMost);
    names.push_back(more);
  }
  return listed(names);
}

}  // namespace

void refuse_negative(const Rig& rig, const std::vector<std::vector<bool>>& used, std::vector<ElementEstimate>& elements,
                     std::vector<Doubt>& doubts) {
  const bool turns = rig.motion == Motion::rotation;
  std::vector<std::string> found;
  std::vector<int> refused;
  std::vector<bool> suspects(rig.channels.size(), false);
  bool surely = false;
  for (std::size_t e = 0; e < elements.size(); ++e) {
    ElementEstimate& element = elements[e];
    if (!element.identifiable || (!negative(element.stiffness) && !negative(element.damping))) continue;
    std::string seen;
    for (const bool is_stiffness : {true, false}) {
      const Coefficient& coefficient = is_stiffness ? element.stiffness : element.damping;
      if (!negative(coefficient)) continue;
      surely = surely || beyond_chance(coefficient);
      const char* unit = is_stiffness ? (turns ? "N·m/rad" : "N/m") : (turns ? "N·m·s/rad" : "N·s/m");
      const std::string figure = plus_minus(coefficient.value, coefficient.U95, unit);
      const std::string name = is_stiffness ? "stiffness" : "damping";
      seen += (seen.empty() ? "its " : " and its ") + name + " comes out as " + figure;
      found.push_back(name + " of element " + std::to_string(element.k) + " comes out as " + figure);
    }
    element.reason = seen + ": a passive element has no negative stiffness or damping";
    element.identifiable = false;
    element.stiffness = element.damping = {};
    element.loss_factor = {};
    element.budget.clear();
    refused.push_back(element.k);
    for (std::size_t c = 0; c < suspects.size(); ++c) suspects[c] = suspects[c] || used[e][c];
  }
  if (refused.empty()) return;
  if (!surely) {
    doubts.push_back({refused,
                      first_of(found, "coefficients") + ": by chance this happens in one of 40 dwells "
                                                        "where an element has next to none; measure longer",
                      true});
    return;
  }
  std::vector<std::string> names;
  Doubt doubt;
  for (std::size_t c = 0; c < suspects.size(); ++c)
    if (suspects[c]) names.push_back(rig.channels[c].name);
  std::vector<int> beside;  // reported elements that are computed from the same channels
  for (std::size_t e = 0; e < elements.size(); ++e) {
    bool shares = false;
    for (std::size_t c = 0; c < suspects.size(); ++c) shares = shares || (suspects[c] && used[e][c]);
    if (!shares) continue;
    doubt.elements.push_back(elements[e].k);
    if (elements[e].identifiable) beside.push_back(elements[e].k);
  }
  doubt.what = first_of(found, "coefficients") +
               ", which no passive element has: check sign, order, unit and instant of " + first_of(names, "channels") +
               (rig.masses.empty() ? "" : ", and the masses");
  if (!beside.empty())
    doubt.what += "; " + elements_text(beside) + (beside.size() == 1 ? " rests" : " rest") + " on the same channels";
  doubts.push_back(std::move(doubt));
}

}  // namespace dwell
