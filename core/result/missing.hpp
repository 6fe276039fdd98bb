// What would explain what a model of the rig leaves over (docs/method.md, What is missing). Plain data.
#pragma once

#include <string>
#include <vector>

#include "core/result/dwell.hpp"

namespace dwell {

// A physical term, or a mistake of the rig file, that the model lacks.
struct MissingTerm {
  std::string what;     // one of the phrases of docs/method.md
  double value = kNaN;  // what the rig file would have to state, or the term's own size; NaN: it has none
  double u = kNaN;      // its standard uncertainty
  std::string unit;     // of both
  double gain = kNaN;   // by which the likelihood's logarithm grows; NaN: nothing could be fitted without it
  std::vector<std::string> or_else;  // terms that the readings do not tell from this one
  // By how much (c, r) of each element would change if the model had this term; empty: not known.
  std::vector<double> moves;
  std::string told;  // as a part of a sentence: "a damper of 2.20 ± 0.10 N·s/m from mass 1 to ground"
};

}  // namespace dwell
