#include "daemon/estimate/run_pipeline.hpp"

#include <utility>

namespace dwell {

RunPipeline::RunPipeline(const Rig& rig, KeptDwells kept, const std::shared_ptr<LongWork>& work, Tell tell)
    : measurement_(rig, std::move(kept),
                   [this, tell = std::move(tell)](RunEvent event) { tell(*this, std::move(event)); }),
      model_(work ? std::make_unique<ModelWork>(work) : nullptr),
      samples_before_(rig.channels.size()) {}

void RunPipeline::born(std::int64_t t_ns, std::int64_t start_utc_ns, const std::vector<std::uint64_t>& given) noexcept {
  born_ns_ = not_idle_ns_ = seen_ns_ = t_ns;
  start_utc_ns_ = start_utc_ns;
  samples_before_ = given;  // of one size: no allocation
}

void RunPipeline::take(const Record& record) {
  show_model(record, position() + 1);
  measurement_.take(record);
  note_state(record.t_ns);
}

std::size_t RunPipeline::take_samples(std::span<const Record> records) noexcept {
  const std::uint64_t before = position();
  const std::size_t n = measurement_.take_samples(records);
  for (std::size_t i = 0; i < n; ++i) show_model(records[i], before + i + 1);
  if (n > 0) note_state(records[n - 1].t_ns);
  return n;
}

void RunPipeline::show_model(const Record& record, std::uint64_t position) noexcept {
  if (!concerns_pipeline(record.kind)) return;
  if (!origin_ns_) origin_ns_ = record.t_ns;
  if (model_) model_->take(record, record.t_ns - *origin_ns_, position);
}

void RunPipeline::note_state(std::int64_t t_ns) noexcept {
  if (measurement_.state() != State::idle) not_idle_ns_ = t_ns;
  if (sees_drive()) seen_ns_ = t_ns;
}

bool RunPipeline::sees_drive() const noexcept {
  return measurement_.state() == State::settling || measurement_.state() == State::measuring;
}

}  // namespace dwell
