#include "daemon/ctl/identify.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

#include "core/dwell/pipeline.hpp"
#include "core/motion/motion_estimate.hpp"
#include "core/motion/motion_recorder.hpp"
#include "core/stream/assembler.hpp"

namespace dwell::ctl {
namespace {

// The pipeline counts from its first record on.
Dwell on_recording_axis(Dwell dwell, double first_s) {
  dwell.start_s += first_s;
  dwell.settled_s += first_s;
  dwell.verdict_s += first_s;
  dwell.end_s += first_s;
  dwell.t_ref_s += first_s;
  return dwell;
}

// A recording's samples in the order in which the pipeline takes them: as they are, or, where a device has a clock of
// its own, at the recovered instants and therefore merged anew.
class Stream {
 public:
  explicit Stream(const Rig& rig) : rig_(rig) {
    const auto own_clock = [](const Device& device) { return device.clock == Clock::device; };
    if (std::none_of(rig.devices.begin(), rig.devices.end(), own_clock)) return;
    std::vector<Assembler::Source> sources = Assembler::sources(rig);
    sources.emplace_back();  // of the channels without a device
    for (std::size_t i = 0; i < rig.channels.size(); ++i)
      if (rig.channels[i].device < 0) sources.back().channels.push_back(static_cast<std::uint16_t>(i));
    devices_ = sources.size();
    assembler_.emplace(sources, ScanClocks::kHoldBack_ns, kMerged);
  }

  template <class Take>
  void push(const Record& record, const Take& take) {
    if (!assembler_) {
      take(record);
      return;
    }
    for (std::size_t i = 0; i < devices_; ++i) assembler_->wait(i, record.t_ns, kUnmarked, kIgnoreAdmission);
    const int device = rig_.channels[record.channel].device;
    assembler_->sample(device < 0 ? devices_ - 1 : static_cast<std::size_t>(device), record, kUnmarked,
                       kIgnoreAdmission);
    for (Record out; assembler_->next(out);) take(out);
  }
  template <class Take>
  void finish(const Take& take) {
    if (!assembler_) return;
    for (std::size_t i = 0; i < devices_; ++i) assembler_->stopped(i, kUnmarked, kIgnoreAdmission);
    for (Record out; assembler_->flush(out);) take(out);
  }

 private:
  static constexpr std::size_t kMerged = 65536;  // samples of a device within the time held back
  static constexpr auto kUnmarked = [](Record&) {};
  static constexpr auto kIgnoreAdmission = [](const Record&, Merger::Admission) {};

  const Rig& rig_;
  std::size_t devices_ = 0;
  std::optional<Assembler> assembler_;  // none: every stamp stands
};

// The recording's samples as records, in the order in which the pipeline takes them.
template <class Take>
void play(const Rig& rig, const CsvRecording& recording, const Progress& progress, const Take& take) {
  constexpr std::size_t progress_every = 1U << 14U;
  const ColumnMatch match = match_columns(rig, recording);
  Stream stream(rig);
  std::size_t until_progress = progress_every;
  for (const CsvRecording::Sample& sample : recording.samples) {
    if (progress && --until_progress == 0) {
      until_progress = progress_every;
      progress(static_cast<double>(&sample - recording.samples.data()) / static_cast<double>(recording.samples.size()));
    }
    const int channel = match.channel_of_column[sample.column];
    if (channel < 0) continue;
    Record record;
    record.t_ns = std::llround(sample.t_s * 1e9);
    record.value = sample.value;
    record.channel = static_cast<std::uint16_t>(channel);
    stream.push(record, take);
  }
  stream.finish(take);
  if (progress) progress(1.0);
}

}  // namespace

ColumnMatch match_columns(const Rig& rig, const CsvRecording& recording) {
  ColumnMatch match;
  std::vector<bool> found(rig.channels.size(), false);
  for (const std::string& column : recording.channels) {
    const auto channel = std::find_if(rig.channels.begin(), rig.channels.end(),
                                      [&column](const Channel& c) { return c.name == column; });
    if (channel == rig.channels.end()) {
      match.channel_of_column.push_back(-1);
      match.unknown_columns.push_back(column);
    } else {
      const auto index = channel - rig.channels.begin();
      match.channel_of_column.push_back(static_cast<int>(index));
      found[static_cast<std::size_t>(index)] = true;
    }
  }
  for (std::size_t i = 0; i < rig.channels.size(); ++i) {
    if (!found[i] && rig.channels[i].measures != Quantity::auxiliary) {
      match.missing_channels.push_back(rig.channels[i].name);
    }
  }
  return match;
}

std::vector<Dwell> identify(const Rig& rig, const CsvRecording& recording, const Progress& progress,
                            VerificationReadings* readings) {
  Pipeline pipeline(rig);
  std::vector<Dwell> dwells;
  double first_s = kNaN;
  play(rig, recording, progress, [&](const Record& record) {
    if (std::isnan(first_s)) first_s = static_cast<double>(record.t_ns) * 1e-9;
    if ((pipeline.push(record) & kCompleted) != 0) dwells.push_back(on_recording_axis(pipeline.completed(), first_s));
    if (readings != nullptr) readings->take(pipeline.readings());
  });
  if ((pipeline.finish() & kCompleted) != 0) dwells.push_back(on_recording_axis(pipeline.completed(), first_s));
  return dwells;
}

MotionEstimate identify_motion(const Rig& rig, const CsvRecording& recording) {
  MotionRecorder recorder(rig);
  play(rig, recording, {}, [&](const Record& record) { recorder.take(record); });
  return estimate_motion(rig, recorder.data());
}

}  // namespace dwell::ctl
