// A run as a universal file: dataset 58 per channel, evenly resampled, SI.
//
// Dataset 58 cannot hold irregular instants: its uneven abscissa has six digits. So each channel is resampled
// (resampler.hpp): band-limited to 0.35 of its rate, with the error stated in ID line 5, in the unit of the values. A
// gap ends a dataset; the channel goes on in another, with the next number in "version number". The first and the last
// 16 readings of a stretch serve as neighbours only. A stretch of fewer than 48 readings is left out and counted.
#pragma once

#include <cstdint>
#include <string>

#include "daemon/handon/output_file.hpp"
#include "daemon/handon/selection.hpp"

namespace dwell::handon {

struct UffOptions {
  bool binary = false;  // 58b, all bits of a double; else 58, text of 13 digits, which every reader reads
};

struct UffDone {
  std::uint64_t samples = 0;   // read
  std::uint64_t values = 0;    // written
  std::uint64_t datasets = 0;  // 58
  std::uint64_t left_out = 0;  // samples in stretches too short to resample
};

// Reads the stream twice, since lengths stand before values. Memory: up to 135 MB in buffers and decoded blocks, and
// 1.5 kB a channel. Fails with "PATH: why"; then there is no file.
[[nodiscard]] Result<UffDone> export_uff(Selection& selection, const Provenance& provenance, const UffOptions& options,
                                         const Target& target, const Progress& progress);

}  // namespace dwell::handon
