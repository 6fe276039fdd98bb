// A run as CSV: one line per sample, `t,channel,value`, each with its own instant; `dwellctl identify` reads it again
// unless CsvOptions::in_unit is set. Nothing is quoted: the rig file allows no comma or quote in a channel's name.
#pragma once

#include <cstdint>
#include <string>

#include "daemon/handon/output_file.hpp"
#include "daemon/handon/selection.hpp"

namespace dwell::handon {

struct CsvOptions {
  bool in_unit = false;  // adds two columns: the reading in the channel's unit, and the unit
};

// Lines that begin with # come first: the run, its head and audit, and per channel unit, scale, offset, place and
// calibration. Then
//
//   t      s on the run's axis, nine decimals: exact
//   value  the device's own number, to which the rig file's scale and offset apply; its shortest decimal
//
// Returns how many samples were written. Fails with "PATH: why"; then there is no file.
[[nodiscard]] Result<std::uint64_t> export_csv(Selection& selection, const Provenance& provenance,
                                               const CsvOptions& options, const Target& target,
                                               const Progress& progress);

// Nanoseconds as seconds, nine decimals: "-0.000000001".
[[nodiscard]] std::string exact_seconds(std::int64_t t_ns);
// The shortest decimal that parses to the same double: "0.1", "1e-07", "-0".
[[nodiscard]] std::string shortest(double value);

}  // namespace dwell::handon
