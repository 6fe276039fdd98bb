// The file of the next run, made before the run begins: making one takes four waits for the disk, and data that come
// meanwhile are in memory only.
#pragma once

#include <cstdint>
#include <future>
#include <optional>
#include <string>
#include <vector>

#include "daemon/record/chain_file.hpp"
#include "daemon/record/run_entries.hpp"

namespace dwell::record {

// Bound to one thread. Makes the file on a thread of its own.
class PreparedRun {
 public:
  explicit PreparedRun(std::string directory) : directory_(std::move(directory)) {}
  ~PreparedRun() { discard(); }
  PreparedRun(const PreparedRun&) = delete;
  PreparedRun& operator=(const PreparedRun&) = delete;

  // Makes the file of this run, unless it is there or being made.
  void make(std::int64_t run);
  // Removes the file if no run has taken it.
  void discard();
  // Waits until it is made.
  void wait() const {
    if (made_.valid()) made_.wait();
  }
  // The file of this run, at path_of(run). Waits if it is not there yet. If it could not be made, tries once more.
  // Fails if another file stands at that name; that file stays.
  [[nodiscard]] Result<ChainWriter> take(std::int64_t run);

  // The first name of a run's file. Each run has its own: when SQLite closes a file, it removes the log at the name by
  // which it opened the file.
  [[nodiscard]] std::string path_of(std::int64_t run) const;
  // The runs whose files a crash left at their first names.
  [[nodiscard]] std::vector<std::int64_t> left_over() const;
  // The header of the run that has begun in such a file; nullopt: the file has no entry. Fails if the file cannot be
  // read; no crash causes that.
  [[nodiscard]] Result<std::optional<RunHeader>> header_of(std::int64_t run) const;
  // Removes this name of a file and of its log. Only for a file that was made here, or that holds nothing.
  void remove(std::int64_t run) const noexcept;

 private:
  const std::string directory_;
  std::int64_t run_ = 0;  // 0: none
  std::future<Result<ChainWriter>> made_;
};

}  // namespace dwell::record
