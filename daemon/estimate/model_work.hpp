// What is computed beside a dwell, on the threads for long work: its coefficients by the method of any motion, and the
// verification of its model. This is the estimation thread's side of it: it gathers what comes by, hands over a job
// when its slot is free, and keeps the results for the next snapshot. It never waits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "core/dwell/pipeline.hpp"
#include "core/motion/transient_watch.hpp"
#include "core/verify/verification_watch.hpp"
#include "daemon/estimate/long_work.hpp"
#include "daemon/estimate/snapshot.hpp"
#include "daemon/record/stream_sink.hpp"

namespace dwell {

// Bound to the estimation thread, the slots of `work` apart.
class ModelWork {
 public:
  // The verdicts on the models of so many dwells are kept, the newest. EstimatorOptions keeps as many dwells.
  static constexpr std::size_t kMostVerdicts = 1000;

  explicit ModelWork(std::shared_ptr<LongWork> work);

  // A record that concerns the pipeline: its instant on the run's axis, and its position in the stream of the run.
  // Real-time safe.
  void take(const Record& record, std::int64_t t_ns, std::uint64_t position) noexcept {
    transient_.take(record, t_ns, position);
  }
  // A dwell has ended with the record `position`.
  void ended(const Dwell& dwell, std::uint64_t position);
  // Call at least once a second, with the readings that count; null: not available now. origin_ns: t = 0 of the run on
  // their clock. Real-time safe.
  void gather(const SampleHistory* readings, std::int64_t origin_ns) noexcept {
    if (readings != nullptr) verification_.take(*readings, origin_ns);
  }
  // Call for each published estimate (`update` of the rig file: once a second at least) on the one object that may use
  // the slots. now: the current dwell, as it stood after the record `position`. pipeline: the dwell's, while it goes
  // on; of an ended run's model any pipeline. Its channel() and condition_reason() are asked, nothing else. Takes
  // finished work back, one job a turn, and hands due jobs over, in two milliseconds at most. Drops a job that another
  // object has handed over before.
  void turn(const Dwell& now, std::uint64_t position, const Pipeline& pipeline);
  // What the last turn() took back; each once.
  [[nodiscard]] std::optional<record::ModelResult> take_news() noexcept { return std::exchange(news_, std::nullopt); }

  void show(const Dwell& now, Snapshot& to) const;

 private:
  void take_back(TransientJob job);
  void take_back(VerificationJob job);
  std::string object(const Dwell& dwell, const MotionEstimate& motion);
  template <class Change>
  void change_verdict(int dwell, Change change);

  const std::shared_ptr<LongWork> work_;  // shared with the workers, which have the slots' other sides
  TransientWatch transient_;
  VerificationWatch verification_;
  std::shared_ptr<const VerifiedModels> models_;
  std::optional<record::ModelResult> news_;
  bool estimate_out_ = false, verification_out_ = false;  // the job in the slot is this one's
};

}  // namespace dwell
