// The destination of a RunLog. It takes one run after the other, as batches of entries; each batch is stored as a whole
// or not at all. RunFolder is the real one.
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

// Bound to one thread. Every call may wait for the disk. A call that fails has written nothing; the reason is for
// people.
class RunStore {
 public:
  virtual ~RunStore() = default;
  // Fails, with the reason, if it is known that no run could begin now. The recorder calls it every 0.25 s while no run
  // goes on.
  [[nodiscard]] virtual Result<void> ready() = 0;
  // Begins a run: puts its number, id, key and predecessor into `header`, writes it and the first entries. t_ns: of the
  // first record.
  [[nodiscard]] virtual Result<void> begin(RunHeader& header, std::int64_t t_ns, std::span<const NewEntry> first) = 0;
  // Writes a batch. It survives a loss of power once this returns.
  [[nodiscard]] virtual Result<void> write(std::span<const NewEntry> batch) = 0;
  // Writes the last entries, with the room that was reserved for them, and ends the run. If this fails, these entries
  // are not written, and the file stays cut off. In any case there is no run afterwards.
  [[nodiscard]] virtual Result<void> end(std::span<const NewEntry> last) = 0;
};

}  // namespace dwell::record
