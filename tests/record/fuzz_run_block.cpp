// Whatever the bytes, the reader of blocks answers: records that another block can hold, or one line about what is
// wrong.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include "daemon/record/block.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace dwell::record;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  std::vector<dwell::Record> records, again;
  const auto decoded = decode_block(bytes, records);
  if (!decoded) {
    if (decoded.error().empty() || decoded.error().find('\n') != std::string::npos || !records.empty()) std::abort();
    // The bytes as records: every record there is must come back.
    records.resize(size / sizeof(dwell::Record));
    if (!records.empty()) std::memcpy(records.data(), data, records.size() * sizeof(dwell::Record));
  }
  if (!decode_block(encode_block(records), again) || again.size() != records.size()) std::abort();
  if (!records.empty() && std::memcmp(records.data(), again.data(), records.size() * sizeof(dwell::Record)) != 0)
    std::abort();
  return 0;
}
