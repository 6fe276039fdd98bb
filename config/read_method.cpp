#include <cmath>
#include <limits>

#include "config/decimal_comma.hpp"
#include "config/draft.hpp"

namespace dwell::config {
namespace {

void read_masses(Section& section, Draft& draft) {
  Rig& rig = draft.file.rig;
  const char* const expected = "an array of numbers, each above 0 (kg, or kg*m2 for rotation)";
  const toml::array* masses = section.array("masses", expected, Need::required);
  const toml::array* mass_u = section.array("mass_u", "an array of numbers, one for each mass, each 0 or more");
  if (masses == nullptr) return;
  if (masses->size() > kMaxMasses) {
    section.wrong("masses", "\"masses\" has " + std::to_string(masses->size()) + " entries: expected at most " +
                                std::to_string(kMaxMasses));
    return;
  }
  draft.masses_known = true;

  const auto numbers = [&](const toml::array& array, const RealRule& rule, const char* what) {
    std::vector<double> out;
    for (const toml::node& node : array) {
      const double number = node.is_number() ? node.value<double>().value_or(std::nan("")) : std::nan("");
      if (!rule.admits(number)) {
        draft.mistakes.add(position(node), std::string(what) + std::to_string(out.size() + 1) + " is " + shown(node) +
                                               ": expected " + rule.expected);
      }
      out.push_back(number);
    }
    return out;
  };
  rig.masses = numbers(*masses, {"a number above 0 (kg, or kg*m2 for rotation)", 0.0, 1e12, true}, "mass ");
  if (mass_u == nullptr) return;
  if (mass_u->size() != masses->size()) {
    section.wrong("mass_u", "\"mass_u\" has " + std::to_string(mass_u->size()) + " entries: expected " +
                                std::to_string(masses->size()) + ", one for each of \"masses\"" +
                                decimal_comma_hint(mass_u->size() > masses->size() ? *mass_u : *masses));
    return;
  }
  rig.mass_u = numbers(*mass_u, {"a number 0 or more, in the unit of the mass", 0.0, 1e12}, "the uncertainty of mass ");
}

void read_rig(Section& section, Draft& draft) {
  Rig& rig = draft.file.rig;
  section.text("name", rig.name, "the rig's name, printable text", Need::required);
  if (section.value("motion") != nullptr) {
    draft.motion_known = section.choice<Motion>("motion", rig.motion,
                                                {{"translation", Motion::translation}, {"rotation", Motion::rotation}});
  }
  draft.boundary_known = section.choice<Boundary>(
      "boundary", rig.boundary, {{"free", Boundary::free}, {"clamped", Boundary::clamped}}, Need::required);
  read_masses(section, draft);
  section.refuse_rest();
}

// A search divides its range into cells of half its lower end: 2000 for a thousandfold. Each reading is added to each
// cell. Doubled: twice the work and the memory (128 kB). Halved: 0.1 to 100 Hz no longer fits one search.
constexpr double kWidestSearch = 1000.0;

void read_search(Section& section, Draft& draft) {
  Excitation& drive = draft.file.rig.excitation;
  drive.search_low_hz = 0.98 * drive.frequency_hz;
  drive.search_high_hz = 1.02 * drive.frequency_hz;
  const char* const expected = "[low, high] in Hz, 0 < low < high at most 1000 low, with \"frequency\" between them";
  double low = 0.0, high = 0.0;
  if (!section.interval("search", low, high, expected)) return;
  const std::string given = "\"search\" is [" + number_text(low) + ", " + number_text(high) + "]";
  if (low <= 0.0 || high > kWidestSearch * low) {
    section.wrong("search", given + ": expected " + expected);
  } else if (draft.frequency_known && (drive.frequency_hz < low || drive.frequency_hz > high)) {
    section.wrong("search", given + ", without the frequency " + number_text(drive.frequency_hz) + " in it: expected " +
                                expected);
  } else {
    drive.search_low_hz = low;
    drive.search_high_hz = high;
  }
}

void read_excitation(Section& section, Draft& draft) {
  Excitation& drive = draft.file.rig.excitation;
  drive.minimum = 1e-6;
  draft.frequency_known =
      section.real("frequency", drive.frequency_hz, {"a number from 0.001 to 100000 (Hz)", 0.001, 1e5}, Need::required);
  section.real("frequency_u", drive.frequency_u_hz, {"a number from 0 to 100 (Hz)", 0.0, 100.0});
  section.real("clock_u", drive.clock_u, {"a number from 0 to 0.01 (relative)", 0.0, 0.01});
  section.real("minimum", drive.minimum,
               {"a number above 0 (m, or rad for rotation)", 0.0, std::numeric_limits<double>::max(), true});
  read_search(section, draft);
  section.choice<Reference>("reference", drive.reference,
                            {{"fixed", Reference::fixed}, {"tracked", Reference::tracked}, {"sync", Reference::sync}});
  std::int64_t harmonics = drive.harmonics;
  section.integer("harmonics", harmonics, 1, kMaxHarmonics, "an integer from 1 to 8");
  drive.harmonics = static_cast<int>(harmonics);
  section.refuse_rest();
}

}  // namespace

void read_method(Section& root, Draft& draft) {
  Rig& rig = draft.file.rig;
  if (const toml::table* table = root.table("rig", "a table [rig]", Need::required)) {
    draft.rig.emplace(*table, "[rig]", draft.mistakes);
    read_rig(*draft.rig, draft);
  }
  if (const toml::table* table = root.table("excitation", "a table [excitation]", Need::required)) {
    draft.excitation.emplace(*table, "[excitation]", draft.mistakes);
    read_excitation(*draft.excitation, draft);
  }
  if (const toml::table* table = root.table("settling", "a table [settling]")) {
    Section section(*table, "[settling]", draft.mistakes);
    section.real("tolerance", rig.tolerance, {"a number above 0, at most 0.5 (relative)", 0.0, 0.5, true});
    section.refuse_rest();
  }
  if (const toml::table* table = root.table("estimation", "a table [estimation]")) {
    draft.estimation.emplace(*table, "[estimation]", draft.mistakes);
    Section& section = *draft.estimation;
    section.real("memory", rig.memory_s, {"a number above 0, at most 604800 (s)", 0.0, 604800.0, true});
    section.real("update", rig.update_s, {"a number from 0.01 to 1 (s)", 0.01, 1.0});
    section.refuse_rest();
  }
  if (const toml::table* table = root.table("verification", "a table [verification]")) {
    Section section(*table, "[verification]", draft.mistakes);
    section.real("accuracy", draft.file.verification.accuracy,
                 {"a number above 0, at most 1 (of each channel's rms)", 0.0, 1.0, true});
    section.boolean("live", draft.file.verification.live);
    section.refuse_rest();
  }
}

}  // namespace dwell::config
