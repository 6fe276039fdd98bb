// One line for people of an `estimate` or `verification` entry of a run file. Thread-safe; allocates.
#pragma once

#include <string>

namespace dwell {

// "from 0.52 s to 3.10 s, 1234 readings: 2 of 2 elements"; "of dwell 1: adequate, E_n 0.42". from, result: the entry's
// members as JSON; what cannot be read is left out.
[[nodiscard]] std::string stored_model_text(const std::string& kind, const std::string& from,
                                            const std::string& result);

}  // namespace dwell
