// A dwell as it stands, but for its coefficients.
//
// The coefficients, their uncertainties and budgets are more than half of the work of an evaluation, and need nothing
// of the pipeline but its rig. So a caller with many evaluations takes the drafts on the pipeline's thread and finishes
// them on another.
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "core/dwell/report.hpp"
#include "core/result/dwell.hpp"
#include "core/rig/rig.hpp"
#include "core/transient/seen_modes.hpp"

namespace dwell {

// What report_elements() is given.
struct DwellEvidence {
  const Rig* rig = nullptr;            // the pipeline's: it must outlive this
  const Eigen::MatrixXd* G = nullptr;  // likewise
  std::vector<ChannelResult> channels;
  double omega = 0.0, u_omega = 0.0;  // rad/s
  std::vector<SeenMode> seen;
};

// Bound to one thread at a time.
class DwellDraft {
 public:
  // A dwell that has no coefficients.
  explicit DwellDraft(Dwell dwell) : dwell_(std::move(dwell)) {}
  DwellDraft(Dwell dwell, DwellEvidence evidence) : dwell_(std::move(dwell)), evidence_(std::move(evidence)) {}

  // The dwell, to the bit as Pipeline::current() gives it. Only once. Allocates. Cost: half of Pipeline::current().
  [[nodiscard]] Dwell finish() {
    if (evidence_.rig != nullptr)
      report_elements(*evidence_.rig, *evidence_.G, evidence_.channels, evidence_.omega, evidence_.u_omega,
                      evidence_.seen, dwell_);
    return std::move(dwell_);
  }

 private:
  Dwell dwell_;
  DwellEvidence evidence_;
};

}  // namespace dwell
