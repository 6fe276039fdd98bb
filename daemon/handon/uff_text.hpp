// The records of a universal file (SDRC/UC-SDRL): dataset 151 (header), 164 (units), 58 (function at nodal DOF). Lines
// of 80 columns and a newline, ASCII. Field by field after the published descriptions of these datasets.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/rig/rig.hpp"

namespace dwell::handon {

// One line: the text cut or padded to 80 columns, everything but printable ASCII as "?", and a newline.
[[nodiscard]] std::string uff_line(std::string_view text);
// The line "    -1" that begins and ends each dataset.
inline constexpr std::string_view kUffMark = "    -1\n";

// "2026-11-23T03:12:18.5Z" becomes "23-NOV-26 03:12:18"; any other text stays as it is.
[[nodiscard]] std::string uff_date(const std::string& utc);

// Dataset 151 with its marks. Instants as ISO 8601.
struct UffHeader {
  std::string model, description, program, created_utc, written_utc;
};
[[nodiscard]] std::string uff_header(const UffHeader& header);

// Dataset 164 with its marks: SI.
[[nodiscard]] std::string uff_units();

// Dataset 58 of one channel and stretch, from its first mark up to its values. Its length does not depend on the texts.
struct UffFunction {
  std::string description, run, date, method, error;  // ID lines 1 to 5
  const Channel* channel = nullptr;
  Motion motion = Motion::translation;
  int node_of_ground = 0;  // one behind the last mass; the table is node 0, mass k node k
  int number = 1;          // of the channel
  int stretch = 1;
  std::int64_t count = 0;  // of values
  double start_s = 0.0, step_s = 0.0;
  bool binary = false;
};
[[nodiscard]] std::string uff_function(const UffFunction& function);

// Bytes of the values of a dataset.
[[nodiscard]] std::int64_t uff_values_size(std::int64_t count, bool binary) noexcept;
// Appends the next value; index: its own, from 0; count: of the dataset.
void uff_value(std::string& text, double value, std::int64_t index, std::int64_t count, bool binary);

}  // namespace dwell::handon
