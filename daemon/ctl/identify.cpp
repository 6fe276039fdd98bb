#include "daemon/ctl/identify.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>

#include "core/dwell/pipeline.hpp"
#include "core/motion/motion_estimate.hpp"
#include "core/motion/motion_recorder.hpp"

namespace dwell::ctl {
namespace {

// Records that the pipeline takes at once. Fewer than it remembers of one channel, so that none is missed by whoever
// keeps the readings; with a quarter as many, blocks of a quarter period are torn apart.
constexpr std::size_t kTogether = 4096;

// The pipeline counts from its first record on.
Dwell on_recording_axis(Dwell dwell, double first_s) {
  dwell.start_s += first_s;
  dwell.settled_s += first_s;
  dwell.verdict_s += first_s;
  dwell.end_s += first_s;
  dwell.t_ref_s += first_s;
  return dwell;
}

// Adds the channels that the dwell withholds because their readings are at fault, each once. Held channels are not
// added: the estimate models them. added: whether to holds this channel already, by channel. to: may be null.
void add_faults(const Rig& rig, const Pipeline& pipeline, const Dwell& dwell, std::vector<bool>& added,
                std::vector<std::string>* to) {
  if (to == nullptr) return;
  for (std::size_t i = 0; i < std::min(rig.channels.size(), dwell.phasors.size()); ++i) {
    const auto c = static_cast<int>(i);
    const Condition condition = pipeline.channel(c).condition;
    const bool foreign = condition == Condition::clipped || condition == Condition::stuck ||
                         condition == Condition::gated || condition == Condition::overrange;
    if (!foreign || added[i] || dwell.phasors[i].valid || rig.channels[i].measures == Quantity::auxiliary) continue;
    const std::string why = pipeline.condition_reason(c);
    to->push_back(rig.channels[i].name + ": " + (why.empty() ? to_string(condition) : why));
    added[i] = true;
  }
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

tl::expected<std::vector<Dwell>, std::string> identify(const Rig& rig, const RecordSource& source,
                                                       const Progress& progress, VerificationReadings* readings,
                                                       std::vector<std::string>* at_fault) {
  Pipeline pipeline(rig);
  std::vector<Dwell> dwells;
  std::vector<bool> faults_added(rig.channels.size());
  double first_s = kNaN;
  std::vector<Record> waiting;
  waiting.reserve(kTogether);
  const auto take_waiting = [&] {
    for (std::span<const Record> left = waiting; !left.empty();) {
      std::size_t taken = pipeline.push_in_block(left);
      if (taken == 0 && (pipeline.push(left[taken++]) & kCompleted) != 0) {
        add_faults(rig, pipeline, pipeline.completed(), faults_added, at_fault);
        dwells.push_back(on_recording_axis(pipeline.completed(), first_s));
      }
      left = left.subspan(taken);
    }
    waiting.clear();
    if (readings != nullptr) readings->take(pipeline.readings());
  };
  const auto played = source.play(progress, [&](const Record& record) {
    if (std::isnan(first_s)) first_s = static_cast<double>(record.t_ns) * 1e-9;
    waiting.push_back(record);
    if (waiting.size() == kTogether) take_waiting();
  });
  if (!played) return tl::unexpected(played.error());
  take_waiting();
  add_faults(rig, pipeline, pipeline.current(), faults_added, at_fault);
  if ((pipeline.finish() & kCompleted) != 0) dwells.push_back(on_recording_axis(pipeline.completed(), first_s));
  return dwells;
}

tl::expected<MotionEstimate, std::string> identify_motion(const Rig& rig, const RecordSource& source,
                                                          std::vector<std::string> at_fault) {
  MotionRecorder recorder(rig);
  const auto played = source.play({}, [&](const Record& record) { recorder.take(record); });
  if (!played) return tl::unexpected(played.error());
  MotionOptions options;
  options.at_fault = std::move(at_fault);
  return estimate_motion(rig, recorder.data(), options);
}

std::vector<Dwell> identify(const Rig& rig, const CsvRecording& recording) {
  return identify(rig, CsvSource(rig, recording)).value();
}

MotionEstimate identify_motion(const Rig& rig, const CsvRecording& recording) {
  return identify_motion(rig, CsvSource(rig, recording)).value();
}

}  // namespace dwell::ctl
