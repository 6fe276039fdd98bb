#include "daemon/ctl/truth.hpp"

#include <cmath>
#include <cstdio>
#include <memory>
#include <vector>

#include "daemon/report/dwell_json_value.hpp"

namespace dwell::ctl {
namespace {

bool numbers(const Json& object, const char* name, std::vector<double>& into) {
  const auto it = object.is_object() ? object.find(name) : object.end();
  if (it == object.end() || !it->is_array()) return false;
  for (const Json& item : *it) {
    if (!item.is_number()) return false;
    into.push_back(item.get<double>());
  }
  return true;
}

bool within(const Coefficient& measured, double truth, double most_u) {
  return std::fabs(measured.value - truth) <= most_u * measured.u;  // false where either is no number
}

}  // namespace

tl::expected<Truth, std::string> read_truth(const std::string& path) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "re"), &std::fclose);
  if (!file) return tl::unexpected(path + ": cannot be read");
  std::string text(1U << 20U, '\0');
  text.resize(std::fread(text.data(), 1, text.size(), file.get()));
  const Json value = Json::parse(text, nullptr, false);
  Truth truth;
  if (!numbers(value, "stiffness", truth.stiffness) || !numbers(value, "damping", truth.damping) ||
      truth.stiffness.size() != truth.damping.size()) {
    return tl::unexpected(path + ": expected {\"stiffness\": [numbers], \"damping\": [as many]}");
  }
  return truth;
}

bool agrees(const Dwell& dwell, const Truth& truth, double most_u, std::string& why) {
  if (dwell.elements.size() != truth.stiffness.size()) {
    why = std::to_string(dwell.elements.size()) + " elements, but the truth has " +
          std::to_string(truth.stiffness.size());
    return false;
  }
  for (std::size_t i = 0; i < truth.stiffness.size(); ++i) {
    const ElementEstimate& e = dwell.elements[i];
    why = "element " + std::to_string(e.k);
    if (!e.identifiable) {
      why += " is not identifiable: " + e.reason;
      return false;
    }
    const bool stiffness = within(e.stiffness, truth.stiffness[i], most_u);
    if (!stiffness || !within(e.damping, truth.damping[i], most_u)) {
      why += stiffness ? ": the damping is off by more than " : ": the stiffness is off by more than ";
      why += std::to_string(static_cast<int>(most_u)) + " standard uncertainties";
      return false;
    }
  }
  why.clear();
  return true;
}

}  // namespace dwell::ctl
