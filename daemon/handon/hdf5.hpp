// Exports a run as HDF5: every sample with its own instant, the device's own number and the value in the channel's
// unit, and the attributes needed to read them.
//
//   /                      attributes: the run (id, number, label, times, who, host, program), the stretch, head, audit
//   /rig_file              the rig file's text
//   /channels/NAME         attributes: name, unit, scale, offset, measures, at, calibration_id, calibration_due, …
//   /channels/NAME/t_ns    int64, ns on the run's axis; 0 is `zero_ns` on the clock that recorded
//   /channels/NAME/value   float64, in `unit`: scale · raw + offset
//   /channels/NAME/raw     float64, the device's own number
//   /channels/NAME/t_half_ns  uint32, ns: the true instant lies within t_ns ± t_half_ns
//   /channels/NAME/flags   uint8: 1 samples were lost before this one, 2 the stamp was replaced by the host's
//   /results               JSON texts, one a row: of the dwells that overlap the stretch (RunReader::dwells)
//   /events                JSON texts, one a row: all events of the run, whatever the stretch
//
// Datasets are chunked and compressed (shuffle, deflate), which every HDF5 library reads.
#pragma once

#include <cstdint>
#include <string>

#include "daemon/handon/output_file.hpp"
#include "daemon/handon/selection.hpp"

namespace dwell::handon {

// Returns how many samples were written. Memory: up to 150 MB in chunks and decoded blocks, whatever the run's length.
// Fails with "PATH: why"; then there is no file.
[[nodiscard]] Result<std::uint64_t> export_hdf5(Selection& selection, const Provenance& provenance,
                                                const Target& target, const Progress& progress);

}  // namespace dwell::handon
