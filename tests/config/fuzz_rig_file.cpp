// Whatever the bytes, the parser answers: a rig, or at least one mistake.
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "tests/config/fake_drivers.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace dwell::config;
  static const SchemaSource schemas = dwell::config::testing::fake_schemas();
  if (size > kMaxFileBytes) return 0;  // refused as a whole, without a position
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  for (const bool checked : {true, false}) {
    const Result<RigFile> file = parse(text, "rig.toml", checked ? schemas : SchemaSource());
    if (!file && (file.error().empty() || file.error().front().line < 1)) std::abort();
  }
  return 0;
}
