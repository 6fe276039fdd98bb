// One pipeline from its birth on, with the work on its model, its place in the stream, and since when it sees no drive.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/rig/rig.hpp"
#include "daemon/estimate/measurement.hpp"
#include "daemon/estimate/model_work.hpp"

namespace dwell {

// Bound to one thread at a time. The constructor allocates everything: 56 MB for 64 channels, which takes 25 ms if the
// process has to get that memory first. So pipelines are made in advance (nursery.hpp).
class RunPipeline {
 public:
  using Tell = std::function<void(RunPipeline&, RunEvent)>;

  // The rig must be valid. work: does what takes seconds; null: that is not done.
  RunPipeline(const Rig& rig, KeptDwells kept, const std::shared_ptr<LongWork>& work, Tell tell);
  RunPipeline(const RunPipeline&) = delete;
  RunPipeline& operator=(const RunPipeline&) = delete;

  // It is born before the next record, at t_ns. start_utc_ns: the same instant. given: by Rig::channels index, samples
  // of the stream so far.
  void born(std::int64_t t_ns, std::int64_t start_utc_ns, const std::vector<std::uint64_t>& given) noexcept;

  // The next record of the stream; the first is RunEdge::armed.
  void take(const Record& record);
  // See Measurement::take_samples().
  [[nodiscard]] std::size_t take_samples(std::span<const Record> records) noexcept;
  // The end of the run: what waits is done, the current dwell completes.
  void finish() { measurement_.finish(); }

  // Records taken: the position of the newest one.
  [[nodiscard]] std::uint64_t position() const noexcept { return measurement_.taken(); }
  [[nodiscard]] std::int64_t start_utc_ns() const noexcept { return start_utc_ns_; }
  // t = 0 of its dwells, ns on the stream's clock: the first record that concerns it; before that, its birth.
  [[nodiscard]] std::int64_t origin_ns() const noexcept { return origin_ns_.value_or(born_ns_); }
  // Samples of a channel that were in the stream before it was born.
  [[nodiscard]] std::uint64_t samples_before(std::size_t channel) const noexcept { return samples_before_[channel]; }

  // A dwell is on.
  [[nodiscard]] bool sees_drive() const noexcept;
  // At t_ns, in stream time, ns: its age; for how long it has been in State::idle; for how long without a dwell.
  [[nodiscard]] std::int64_t age_ns(std::int64_t t_ns) const noexcept { return t_ns - born_ns_; }
  [[nodiscard]] std::int64_t idle_for_ns(std::int64_t t_ns) const noexcept { return t_ns - not_idle_ns_; }
  [[nodiscard]] std::int64_t unseen_for_ns(std::int64_t t_ns) const noexcept { return t_ns - seen_ns_; }

  // A dwell that ended with the record taken last, while no run went on. A run that begins later reaches back to it and
  // stores it.
  void keep_for_run(std::shared_ptr<const Dwell> dwell) { for_run_.push_back({position(), std::move(dwell)}); }
  struct Ended {
    std::uint64_t position;
    std::shared_ptr<const Dwell> dwell;
  };
  // Those, in order; each once.
  [[nodiscard]] std::vector<Ended> take_for_run() noexcept { return std::exchange(for_run_, {}); }

  [[nodiscard]] Measurement& measurement() noexcept { return measurement_; }
  [[nodiscard]] const Measurement& measurement() const noexcept { return measurement_; }
  [[nodiscard]] ModelWork* model() noexcept { return model_.get(); }  // null: there is none
  [[nodiscard]] std::unique_ptr<ModelWork> release_model() noexcept { return std::move(model_); }

 private:
  void show_model(const Record& record, std::uint64_t position) noexcept;
  void note_state(std::int64_t t_ns) noexcept;

  Measurement measurement_;
  std::unique_ptr<ModelWork> model_;
  std::vector<std::uint64_t> samples_before_;
  std::vector<Ended> for_run_;
  std::int64_t born_ns_ = 0, start_utc_ns_ = 0;
  std::optional<std::int64_t> origin_ns_;
  std::int64_t not_idle_ns_ = 0;  // of the newest record after which it was not idle
  std::int64_t seen_ns_ = 0;      // of the newest record after which a dwell was on
};

}  // namespace dwell
