// Whatever the bytes, the reader of recordings answers: a recording that keeps its promises, or a mistake with its
// place.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "drivers/replay/csv_recording.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto recording = dwell::parse_csv(text, "f.csv");
  if (!recording) {
    if (recording.error().rfind("f.csv", 0) != 0) std::abort();
    return 0;
  }
  if (recording->samples.empty() || recording->channels.size() > dwell::kCsvMaxChannels) std::abort();
  double previous_s = -dwell::kCsvLatest;
  for (const auto& sample : recording->samples) {
    if (!std::isfinite(sample.value) || !(std::abs(sample.t_s) <= dwell::kCsvLatest)) std::abort();
    if (sample.t_s < previous_s || sample.column >= recording->channels.size()) std::abort();
    previous_s = sample.t_s;
  }
  return 0;
}
