// Where a RunLog writes: one run after the other, each a row of entries in batches that are kept whole or not at all.
// RunFolder is the real one.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "daemon/record/keys.hpp"
#include "daemon/record/run_entries.hpp"

namespace dwell::record {

struct NewEntry {
  std::string kind;
  std::int64_t t_ns = 0;
  std::string body;
};

// Bound to one thread. Every call may wait for the disk. What fails has written nothing; the reason is for people.
class RunStore {
 public:
  virtual ~RunStore() = default;
  // Whether a run could begin now, as far as can be told beforehand; why not.
  [[nodiscard]] virtual Result<void> ready() = 0;
  // Begins a run: puts its number, id, key and predecessor into `header`, writes it and the first entries. t_ns: of the
  // first record.
  [[nodiscard]] virtual Result<void> begin(RunHeader& header, std::int64_t t_ns, std::span<const NewEntry> first) = 0;
  // They survive a loss of power once this returns.
  [[nodiscard]] virtual Result<void> write(std::span<const NewEntry> batch) = 0;
  // Writes the last entries, with the room that was reserved for them, and closes the run. Where even that fails, the
  // run stays as it is, cut off. In either case there is no run afterwards.
  [[nodiscard]] virtual Result<void> end(std::span<const NewEntry> last) = 0;
};

}  // namespace dwell::record
