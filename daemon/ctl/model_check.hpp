// Computes the estimates by any motion and the verifications of a run again and compares them with those stored in the
// run file. When one was published depends on the processor's time; what it says does not: its entry names all that it
// was computed from (daemon/report/model_entry.hpp).
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <future>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "core/rig/rig.hpp"
#include "core/stream/record.hpp"
#include "daemon/ctl/estimates_again.hpp"
#include "daemon/ctl/replay.hpp"
#include "daemon/ctl/replay_check.hpp"
#include "daemon/ctl/verifications_again.hpp"
#include "daemon/record/run_reader.hpp"
#include "daemon/report/model_entry.hpp"

namespace dwell::ctl {

// Bound to one thread; computes on others, one for each processor. An estimate or a verification takes seconds, one
// that looks for causes minutes.
class ModelCheck {
 public:
  // Texts of estimates and verifications beyond this are refused: those of a day of dwells of a minute. They are kept
  // twice at most.
  static constexpr std::size_t kMostBytes = std::size_t{64} << 20U;
  static constexpr std::size_t kMostEntries = 50'000;

  // Reads all that the run holds of both; its dwells are those of the replay. accuracy: of the rig file. Fails where
  // there are too many, or the file cannot be read.
  [[nodiscard]] static record::Result<ModelCheck> open(record::RunReader& run, const Rig& rig, double accuracy);
  ModelCheck(ModelCheck&&) = default;  // before the first follow() only
  ModelCheck& operator=(ModelCheck&&) = delete;
  // Without finish(): what is being computed is stopped.
  ~ModelCheck() { stop_.request_stop(); }

  // How many records the replay may take before follow() must be called.
  [[nodiscard]] std::uint64_t free_until(const Replay& replay) const noexcept {
    return verifications_.free_until(replay);
  }
  // Call with the records that the replay has taken last: one, or those of one take_samples().
  void follow(std::span<const Record> taken, const Replay& replay);
  // Call after the last record: waits for the computations. dwells: all that ended in the replay.
  void finish(const std::vector<Dwell>& dwells, ReplayFindings& to);

 private:
  // Estimates have `estimate` until finish() adds the objection of their dwell; verifications have `entry` at once.
  struct Again {
    record::StoredModel stored;
    std::optional<TransientEstimate> estimate = {};
    ModelEntry entry = {};
  };
  // What the run holds, sorted.
  struct Published {
    std::vector<PublishedEstimate> estimates;
    std::vector<PublishedVerification> verifications;
    std::uint64_t older = 0;       // estimates of an older program
    std::vector<Finding> wrong{};  // entries that cannot be computed again
  };

  ModelCheck(const Rig& rig, double accuracy, Published published);
  [[nodiscard]] static tl::expected<void, std::string> sort(const record::StoredModel& stored, const Rig& rig,
                                                            Published& to);
  void compute(std::function<void()> work);
  void compare(const Again& again, ReplayFindings& to) const;

  const Rig* rig_;
  double accuracy_;
  EstimatesAgain estimates_;
  VerificationsAgain verifications_;
  std::uint64_t older_;         // estimates of an older program
  std::vector<Finding> wrong_;  // entries that cannot be computed again
  std::stop_source stop_;
  std::optional<std::int64_t> origin_ns_;    // t = 0 of the run
  std::deque<Again> again_;                  // their addresses stay
  std::deque<std::future<void>> computing_;  // last: waits for its threads before the rest goes
};

}  // namespace dwell::ctl
