// The sample dwells as the service tells them, as JSON on one line.
#pragma once

#include <string>

#include "daemon/report/dwell_json.hpp"
#include "tests/ctl/sample_dwell.hpp"

namespace dwell::test {

inline std::string sample_text() { return to_json(sample_dwell(), sample_rig(), sample_run()); }
inline std::string settling_text() { return to_json(settling_dwell(), sample_rig(), sample_run()); }
// Of a service whose estimation hangs.
inline std::string stale_text() {
  Dwell dwell = sample_dwell();
  dwell.doubts = {{{}, "stale: the service itself does not work: thread estimate has not turned for 5.6 s"}};
  DwellView view = make_view(dwell, sample_rig(), sample_run());
  view.age = LiveAge{5.7, true};
  return to_json(view);
}

}  // namespace dwell::test
