// The list of the runs of a recording directory, for people and machines. Kept in memory, so that no request reads a
// file.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace dwell::record {

struct ListedRun {
  std::int64_t run = 0;  // the ledger's number
  std::string file;      // its name in the directory
  std::string label, begun_by;
  std::string begun_utc;
  std::string ended_utc;      // of one that was cut off: of its last entry; empty: it goes on
  std::string state;          // "recording", "ending": its file is not closed yet, "closed", "cut off", "unreadable"
  std::uint64_t bytes = 0;    // on the disk, its -wal included
  std::uint64_t samples = 0;  // 0: not known, the run was cut off
  std::uint64_t dwells = 0;   // that have ended in it
  std::string head;           // of its last entry, hexadecimal; empty while it goes on
  bool kept = false;          // protected: retention never deletes it
  bool linked = false;        // the file is a symbolic link
  bool clock_synchronized = false;  // when it began: else its instants may be wrong by years
};

using ListedRuns = std::vector<ListedRun>;  // oldest first

// Reads the file `name` of the directory. If the file or one of its results cannot be read, it is listed as
// "unreadable". Reads all stored results, so the time goes with the run's length.
[[nodiscard]] ListedRun look_at_run(const std::string& directory, const std::string& name);

// Lists all run files of the directory but `running`, one by one; asks `stop` between them.
void look_at_runs(const std::string& directory, const std::string& running, const std::function<void(ListedRun)>& take,
                  const std::function<bool()>& stop);

// Whether a file NAME.keep stands beside the run's file.
[[nodiscard]] bool is_kept(const std::string& directory, const std::string& name);

// Thread-safe: any thread writes and reads.
class RunList {
 public:
  // The newest runs that are listed: 5 MB. Older files stay where they are, and can be read by name.
  static constexpr std::size_t kListed = 10'000;

  // Adds it, or replaces the entry of the same file.
  void put(ListedRun run);
  void remove(const std::string& file);
  [[nodiscard]] std::shared_ptr<const ListedRuns> all() const;

 private:
  mutable std::mutex mutex_;
  std::shared_ptr<const ListedRuns> runs_ = std::make_shared<const ListedRuns>();
};

}  // namespace dwell::record
