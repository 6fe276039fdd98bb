// Whatever an answer holds, the reader of dwells answers: a dwell that can be written again, or why it is none.
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "daemon/report/dwell_json.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto dwell = dwell::parse_dwell({reinterpret_cast<const char*>(data), size});
  if (!dwell) {
    if (dwell.error().empty()) std::abort();
    return 0;
  }
  if (!dwell::parse_dwell(dwell::to_json(*dwell))) std::abort();
  return 0;
}
