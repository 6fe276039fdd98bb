// One line for people of an `estimate` or `verification` entry of a run file. Thread-safe; allocates.
#pragma once

#include <string>
#include <vector>

namespace dwell {

// "from 0.52 s to 3.10 s, 1234 readings: 2 of 2 elements"; "of dwell 1: adequate, off by 0.15 ± 0.08 % (accuracy 5 %),
// E_n 0.42". from, result: the entry's
// members as JSON; what cannot be read is left out.
[[nodiscard]] std::string stored_model_text(const std::string& kind, const std::string& from,
                                            const std::string& result);

// What E_n means, for below a list of such lines.
inline constexpr const char* kMeaningOfEn =
    "E_n: the error of the worst channel over its expanded uncertainty; satisfactory up to 1";

struct StoredElement {
  std::string k, stiffness, damping;  // "24.000 ± 0.074 kN/m"; "—": not identifiable
};
// The elements of an `estimate` entry; empty: it has no coefficients. result: as above.
[[nodiscard]] std::vector<StoredElement> stored_elements(const std::string& result);
// What stands against these coefficients, one sentence each: why the chain is refused, what the rig file may lack, what
// the estimate holds against its dwell, its warnings. Empty: nothing does. result: as above.
[[nodiscard]] std::vector<std::string> stored_cautions(const std::string& result);

}  // namespace dwell
