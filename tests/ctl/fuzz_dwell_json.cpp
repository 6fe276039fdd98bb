// Any bytes give a dwell that can be written again, or an error that says why they are none. The same holds for the
// text `from` of an estimate and of a verification.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "daemon/report/dwell_json.hpp"
#include "daemon/report/model_entry.hpp"

namespace {

void sure(bool holds) {
  if (!holds) std::abort();
}

const dwell::Rig& rig() {
  static const dwell::Rig one = [] {
    dwell::Rig rig;
    rig.channels.resize(2);
    rig.channels[0].name = "y0";
    rig.channels[1].name = "y1";
    return rig;
  }();
  return one;
}

void read_dwell(const std::string& text) {
  const auto dwell = dwell::parse_dwell(text);
  if (!dwell) return sure(!dwell.error().empty());
  sure(dwell::parse_dwell(dwell::to_json(*dwell)).has_value());
}

void read_sources(const std::string& text) {
  const auto estimate = dwell::estimate_in(text, rig());
  sure(estimate.has_value() || !estimate.error().empty());
  if (estimate && *estimate) sure(dwell::estimate_in(dwell::model_entry(**estimate, rig()).from, rig()).has_value());
  const auto verified = dwell::verified_in(text);
  sure(verified.has_value() || !verified.error().empty());
  if (verified) sure(dwell::verified_in(dwell::model_entry(*verified, rig()).from).has_value());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  read_dwell(text);
  read_sources(text);
  return 0;
}
