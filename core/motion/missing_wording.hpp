// Terms that a model lacks, in words: value in the unit of the rig file, and a part of a sentence.
#pragma once

#include <string>
#include <vector>

#include "core/motion/unknowns.hpp"
#include "core/result/missing.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// departure: of the term from what the rig file states, or its size; u: its standard uncertainty.
[[nodiscard]] MissingTerm missing_term(const Rig& rig, const Parameter& term, double departure, double u, double gain);

// "a damper of 2.20 ± 0.10 N·s/m from mass 1 to ground or a mass 2 of 8.3 ± 0.1 kg instead of 8 kg": of all terms.
[[nodiscard]] std::string told_together(const std::vector<MissingTerm>& terms);

}  // namespace dwell
