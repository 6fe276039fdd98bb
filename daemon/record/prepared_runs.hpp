// The files of the next runs, made before the runs begin: making one takes four waits for the disk, and data that come
// meanwhile are in memory only.
#pragma once

#include <cstdint>
#include <future>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "daemon/record/chain_file.hpp"
#include "daemon/record/run_entries.hpp"

namespace dwell::record {

// Bound to one thread. Makes each file on a thread of its own.
class PreparedRuns {
 public:
  explicit PreparedRuns(std::string directory) : directory_(std::move(directory)) {}
  ~PreparedRuns() { discard(); }
  PreparedRuns(const PreparedRuns&) = delete;
  PreparedRuns& operator=(const PreparedRuns&) = delete;

  // Making a file takes four waits. That of run N + 3 is begun when N has begun. Before N + 3 begins, five waits pass:
  // for the end of N, and for beginning and end of N + 1 and N + 2. With 2, only three would pass.
  static constexpr std::int64_t kAhead = 3;

  // Makes the files of this run and of those after it, kAhead in all, unless they are there or being made. Removes all
  // others that no run has taken.
  void make(std::int64_t run);
  // Removes the files that no run has taken.
  void discard();
  // Waits until all are made.
  void wait() const {
    for (const auto& [run, file] : made_) file.wait();
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
  using Made = std::map<std::int64_t, std::future<Result<ChainWriter>>>;
  Made::iterator discard(Made::iterator one);

  const std::string directory_;
  Made made_;
};

}  // namespace dwell::record
