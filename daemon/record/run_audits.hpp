// Audits the runs of a recording directory in the background and remembers what came out.
//
// One file at a time, the newest run first, on a thread of the lowest priority. A verdict holds until the size or the
// modification time of the file, or of the -wal beside it, changes. Then the file is audited again; so is one that
// could not be, at the next look. A verdict says what the file was when it was read: whoever needs to be sure now runs
// `dwellctl audit`.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/record/audit.hpp"
#include "daemon/record/job_thread.hpp"
#include "daemon/record/run_list.hpp"

namespace dwell::record {

struct RunVerdict {
  std::string why_none;  // why there is no verdict; empty: there is one
  AuditState state = AuditState::tampered;
  std::string where;  // this and the next three: as Audit has them
  std::optional<double> until_s;
  std::string until_utc;
  bool trusted = false;
  std::string utc;       // when it was audited
  bool removed = false;  // there is none because the file is no longer there
};

// By the name of the file. A run without an entry waits for its turn, is still recorded, or is not among the newest
// kAudited.
using RunVerdicts = std::map<std::string, RunVerdict>;

class RunAudits {
 public:
  // So many of the newest runs are audited: as many as one answer of /api/v1/runs holds. Larger: each start of the
  // service reads more of the disk.
  static constexpr std::size_t kAudited = 100;
  // While the list of runs stays the same, the service looks so often whether files have changed. Longer: a file that
  // was altered is found later.
  static constexpr std::int64_t kLookAgain_ns = 60'000'000'000;

  // The ledger that verdicts rest on lies in the directory.
  explicit RunAudits(std::string directory);

  // One pass; never waits for the disk. runs: all that are listed. key: the service's own, pinned for the audits: a run
  // is trusted if this key signed it, or one that the ledger connects with it. Bound to one thread; virtual time.
  void turn(std::int64_t now_ns, const std::shared_ptr<const ListedRuns>& runs, const PublicKey& key);
  // What was found tampered since the last call, one line each. As turn().
  [[nodiscard]] std::vector<std::string> take_tampered();

  // Thread-safe, short lock.
  [[nodiscard]] std::shared_ptr<const RunVerdicts> all() const;

 private:
  struct Shared;

  const std::shared_ptr<Shared> shared_;
  std::shared_ptr<const ListedRuns> asked_;  // of the newest job
  std::int64_t next_look_ns_ = 0;
  JobThread jobs_;
};

}  // namespace dwell::record
