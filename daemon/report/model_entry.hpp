// The texts of an `estimate` or `verification` entry of a run file (docs/run-file.md): the result, and all that it was
// computed from, so that it can be computed again. Thread-safe; allocates.
#pragma once

#include <optional>
#include <string>
#include <tl/expected.hpp>

#include "core/motion/transient_watch.hpp"
#include "core/rig/rig.hpp"
#include "core/verify/verification_watch.hpp"

namespace dwell {

// Both are JSON objects.
struct ModelEntry {
  std::string from, result;
};
[[nodiscard]] ModelEntry model_entry(const TransientEstimate& of, const Rig& rig);
[[nodiscard]] ModelEntry model_entry(const VerifiedDwell& of, const Rig& rig);

// Read the text `from` back. `estimate` and `objection`, or `dwell` and `verification`, stay empty. rig: the run's. An
// error says which member is missing or of another type. nullopt: an older program wrote it, without `may_search`.
[[nodiscard]] tl::expected<std::optional<TransientEstimate>, std::string> estimate_in(const std::string& from,
                                                                                      const Rig& rig);
[[nodiscard]] tl::expected<VerifiedDwell, std::string> verified_in(const std::string& from);

}  // namespace dwell
