// Reads a run file: its header, its stream record by record, its results, events and signatures. Does not check chain
// or signatures: audit.hpp does. Every instant that it hands out is within the bounds of instants.hpp, but the stamps
// of drivers.
#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/stream/record.hpp"
#include "daemon/record/run_entries.hpp"

namespace dwell::record {

// Bound to one thread. Memory: three blocks at a time, whatever the file's size.
class RunReader {
 public:
  // Fails with "FILE: what is wrong".
  [[nodiscard]] static Result<RunReader> open(const std::string& path);
  RunReader(RunReader&&) noexcept;
  RunReader& operator=(RunReader&&) noexcept;
  ~RunReader();

  // As the `run` entry has it, but with the label that the run was given last.
  [[nodiscard]] const RunHeader& header() const noexcept;
  // How the run ended; none: it is being recorded, or was cut off.
  [[nodiscard]] const std::optional<RunEnd>& end() const noexcept;
  // The instants at which the stream begins and ends; both 0: there is no stream. For progress bars.
  [[nodiscard]] std::int64_t begin_ns() const noexcept;
  [[nodiscard]] std::int64_t end_ns() const noexcept;
  // Duration of the stream, s. A child file holds no stream: then that of its parent's stream, by the entries `run` and
  // `end`. None: not known.
  [[nodiscard]] std::optional<double> span_s() const noexcept;
  // UTC of the stream's end: begun + span_s(). Not the `utc` of the `end` entry, which says when that was written; of a
  // child file, when it was computed. Empty: not known.
  [[nodiscard]] std::string ended_utc() const;

  // Each hands its items to `take`, in order, as long as that returns true. take must not call this reader. Fails with
  // "FILE: entry N: what is wrong", possibly after some items.
  //
  // Takes a block of the stream; returns whether to go on.
  using TakeBlock = std::function<bool(std::span<const Record>)>;
  // Every block of the stream.
  [[nodiscard]] Result<void> blocks(const TakeBlock& take);
  // Every record of the stream; blocks are read on a thread of its own, ahead of `take`. Cost: about 0.02 µs a record.
  template <class Take>
  [[nodiscard]] Result<void> stream(const Take& take) {
    return blocks(each_of(take));
  }
  // The same, from the block on that holds the instant t_ns; none if the stream ends before.
  template <class Take>
  [[nodiscard]] Result<void> stream_from(std::int64_t t_ns, const Take& take) {
    return blocks_from(t_ns, each_of(take));
  }
  // finals: only the final results of dwells.
  [[nodiscard]] Result<void> results(bool finals, const std::function<bool(const StoredResult&)>& take);
  // The final result of each dwell; then the newest result of the dwell that went on when the record stopped: in a run
  // that is still recorded, was cut off, or was ended by a full disk.
  [[nodiscard]] Result<void> dwells(const std::function<bool(const StoredResult&)>& take);
  [[nodiscard]] Result<void> events(const std::function<bool(const StoredEvent&)>& take);
  // Estimates from transients, then verifications; each in the order in which they were published.
  [[nodiscard]] Result<void> models(const std::function<bool(const StoredModel&)>& take);
  // Fails where there are more than 1000.
  [[nodiscard]] Result<std::vector<PersonalSignature>> signatures();

 private:
  // Inline, so that a record costs no call by a pointer.
  template <class Take>
  [[nodiscard]] static TakeBlock each_of(const Take& take) {
    return [&take](std::span<const Record> block) { return std::all_of(block.begin(), block.end(), std::ref(take)); };
  }
  [[nodiscard]] Result<void> blocks_from(std::int64_t t_ns, const TakeBlock& take);

  struct Impl;
  explicit RunReader(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace dwell::record
