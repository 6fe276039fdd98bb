#include "daemon/record/last_entry.hpp"

#include <utility>

namespace dwell::record {

Result<ChainReader::Row> last_entry(ChainReader& reader) {
  const auto at = [&reader](std::int64_t seq) {
    reader.seek(seq);
    return reader.next();
  };
  // Invariant: entry `last.entry.seq` exists; entry `beyond`, once known, does not.
  auto first = at(1);
  if (!first) return tl::unexpected(first.error());
  if (!*first) return tl::unexpected(std::string("no entry"));
  ChainReader::Row last = std::move(**first);
  std::int64_t beyond = 0;
  while (beyond == 0 || last.entry.seq + 1 < beyond) {
    const std::int64_t seq = beyond == 0 ? 2 * last.entry.seq : last.entry.seq + (beyond - last.entry.seq) / 2;
    auto row = at(seq);
    if (!row) return tl::unexpected(row.error());
    if (*row) {
      last = std::move(**row);
    } else {
      beyond = seq;
    }
  }
  return last;
}

}  // namespace dwell::record
