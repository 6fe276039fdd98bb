// Run files of the steady rig: eight channels, a result and a signature each second.
#pragma once

#include <string>

namespace dwell {

// Path of the file, in memory where the system has room for files there. Made at the first call; removed at the end of
// the program.
const std::string& steady_run(double rate_hz, double duration_s);

}  // namespace dwell
