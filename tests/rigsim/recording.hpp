// A recording of the simulated rig as text, in the forms that `dwellctl identify` reads.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "tests/rigsim/options.hpp"

namespace rigsim {

struct RecordingOptions {
  double duration_s = 30.0;
  double rate_hz = 1000.0;  // per channel
  double skew_s = 0.0;      // the last channel is sampled this much after the first, the others evenly between
  double jitter = 0.0;      // of every instant: uniform, ± this part of the interval, < 0.5
  bool long_form =
      false;  // t,channel,value with each sample's own instant; else t,y0,… with the scan's nominal instant,
              // as a careless logger would write it: what skew and jitter do is then not in the file
  std::vector<std::string> script{};  // "SECONDS CONTROL LINE", in the order of time
};

// Writes it, every number with 17 digits; noise, quantization, stuck and invalid readings included. Invalid ones are
// left out (wide: an empty cell). Returns what is wrong with the options, or empty.
[[nodiscard]] std::string write_recording(std::ostream& out, const Options& rig, const RecordingOptions& recording);

}  // namespace rigsim
