// The identified model for other programs: M, D and K as Matrix Market files, and a state-space model as JSON with
// units, covariance, validity and verdict.
//
//   M y'' + D y' + K y = b_K y_0 + b_D y_0' ,   x = (y_1 … y_n, y_1' … y_n'),   x' = A x + B (y_0, y_0')
//   outputs C x + D (y_0, y_0'): y_1 … y_n, and of a clamped chain the force on the ground
//
// Matrix Market: R. F. Boisvert, R. Pozo, K. A. Remington, NISTIR 5935 (1996); symmetric, the lower triangle.
#pragma once

#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "core/result/verification.hpp"
#include "core/rig/rig.hpp"
#include "daemon/report/dwell_view.hpp"

namespace dwell {

struct ModelFile {
  std::string name, text;
};

// mass.mtx, damping.mtx, stiffness.mtx (of a chain with masses) and model.json. The error: why the dwell gives no
// complete chain, in one line. Bound to one thread: allocates.
[[nodiscard]] tl::expected<std::vector<ModelFile>, std::string> model_files(const Rig& rig, const RunInfo& run,
                                                                            const Dwell& dwell,
                                                                            const Verification& verification);

}  // namespace dwell
