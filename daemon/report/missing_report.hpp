// What a model lacks, as JSON and as people read it: the same for any motion and for a verification.
//
// Bound to one thread, not real-time: allocates. Heavy: include it in .cpp only.
#pragma once

#include <string>
#include <vector>

#include "core/result/missing.hpp"
#include "daemon/report/json_parts.hpp"

namespace dwell {

[[nodiscard]] Json json_value(const std::vector<MissingTerm>& missing);
// The same read again; throws a json_reader::Mistake.
[[nodiscard]] std::vector<MissingTerm> missing_from(const Json& list);

// "damping of mass 1 to ground: 2.20 ± 0.10 N·s/m, gain 1500", and what it cannot be told from.
[[nodiscard]] std::string missing_text(const MissingTerm& term);

}  // namespace dwell
